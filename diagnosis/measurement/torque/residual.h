// SPDX-License-Identifier: BSD-3-Clause
// Residual effort of any model on the same samples, to compare models of different origin.
#pragma once

#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Residual [N m or N] of one joint at the used samples of a recording. The effort is corrected for late commands, lag,
// a late log and the torque scale; the joint's laws and the bodies are subtracted; the result is divided by the scale.
// `tau`: inverse dynamics of the bodies, full grid [N m].
std::vector<double> calc_torque_left(const TorqueData& data, const TorqueRecording& recording, const Plant& plant,
                                     const Eigen::VectorXd& tau, int joint);

// Inverse dynamics of the bodies along a recording's motion [N m], full grid x joint. Links behind elastic gears swing
// beside their drives.
Eigen::MatrixXd calc_bodies(const TorqueData& data, const Plant& plant, const TorqueRecording& recording);

// Root mean square of this residual by joint [N m or N], over used samples of held-out (`held`) or training recordings;
// NaN if there are none.
std::vector<double> calc_torque_residuals(const TorqueData& data, const Plant& plant, bool held);

}  // namespace hrp::diagnosis
