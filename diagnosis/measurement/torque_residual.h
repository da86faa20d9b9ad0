// SPDX-License-Identifier: BSD-3-Clause
// What any model leaves of the efforts, on the same samples for all models: to compare models of different origin.
#pragma once

#include "diagnosis/measurement/torque.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Effort [N m or N] that a model leaves at the samples in use of a recording, one joint: effort x scale, with late commands
// and a late log allowed for, less what the joint's laws and the bodies take, over the scale. `tau`: by the bodies, full grid.
std::vector<double> calc_torque_left(const TorqueData& data, const TorqueRecording& recording, const Plant& plant,
                                     const Eigen::VectorXd& tau, int joint);

// Torques of the bodies along a recording's motion, full grid x joint.
Eigen::MatrixXd calc_bodies(const TorqueData& data, const Plant& plant, const TorqueRecording& recording);

// Root mean square by joint [N m or N] of that; samples in use of held-out recordings (`held`) or of
// training. NaN: none.
std::vector<double> calc_torque_residuals(const TorqueData& data, const Plant& plant, bool held);

}  // namespace hrp::diagnosis
