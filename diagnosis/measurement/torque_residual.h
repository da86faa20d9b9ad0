// SPDX-License-Identifier: BSD-3-Clause
// What any model leaves of the efforts, on the same samples for all models: to compare models of different origin.
#pragma once

#include "diagnosis/measurement/torque.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Root mean square by joint [N m or N] of effort x scale, with late commands allowed for, less what the plant's bodies
// and joint laws take, over the scale; samples in use of held-out recordings (`held`) or of training. NaN: none.
std::vector<double> calc_torque_residuals(const TorqueData& data, const Plant& plant, bool held);

}  // namespace hrp::diagnosis
