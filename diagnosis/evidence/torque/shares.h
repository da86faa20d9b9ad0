// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// Held-out mean square of a joint that each term of a fitted model removes (Shapley value): the joint's own terms, then
// those of the whole robot.
std::vector<double> calc_term_shares(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit,
                                     size_t joint);

}  // namespace hrp::diagnosis
