// SPDX-License-Identifier: BSD-3-Clause
// The missing torque at the kept samples, and which of them tell something.
#pragma once

#include "diagnosis/measurement/torque/work.h"

namespace hrp::diagnosis {

// Missing torque: effort minus bodies minus the joint's own laws. Used where the joint moves and its torques are known.
void make_missing_torque(TorqueWork* work, TorqueRecording* recording);

// Largest value of a function of the full grid within the filter's reach of each kept sample. NaN: no value.
Eigen::VectorXd find_largest_near(const Eigen::VectorXd& full, const TorqueRecording& recording, double cutoff);

// A servo that oscillates between its limits jumps by twice the limit within a sample. The filtered error of half a
// sample is then larger than friction. Such stretches are left out if enough others remain.
void leave_out_limits(TorqueWork* work, int joint);

// Takes the ripple out of the effort that its log has beside the servo's law: it is no torque, and would stand in for
// one.
void take_out_log_ripple(TorqueWork* work, int joint);

}  // namespace hrp::diagnosis
