// SPDX-License-Identifier: BSD-3-Clause
// What logs of a robot on a fixed base count otherwise than the model, in the order in which one fault looks like
// another: signs of efforts, torque that is not in them, angles of motors, late commands, units, friction that is not
// there, zeros, gravity.
#pragma once

#include "diagnosis/conventions/log_conventions.h"

namespace hrp::diagnosis {

// Throws InputError as find_conventions() does.
LogConventions find_joint_conventions(const Experiment& experiment, int jobs);

// Whole torques in the model's sense, angles of joints, and commands at their times.
Experiment convert_motion(const Experiment& experiment, const LogConventions& conventions);

}  // namespace hrp::diagnosis
