// SPDX-License-Identifier: BSD-3-Clause
// How well the torque constants of a robot's drives are known, where the model does not fit them.
#pragma once

#include <vector>

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// Standard deviation [1] to which each joint's torque constant is known, by joint of the design.
//
// Without fitted gains: 2 %, as data sheets give it. Gains that the model fits to some joints show how far the
// constants of this robot are off. Where the motion does not show a joint's gain, its constant may be off as far:
// friction of 0.1 N m behind a drive that gives 0.86 of its log reads 0.116 N m, with whatever motion. Where it shows,
// the recordings narrow it (normal prior and likelihood: the inverse variances add up). The spread is that for one more
// drive, as between parts of recordings (intervals.h).
std::vector<double> calc_gain_std(const TorqueDesign& design, const TorqueModel& model, const TorqueFit& fit);

}  // namespace hrp::diagnosis
