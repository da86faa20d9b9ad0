// SPDX-License-Identifier: BSD-3-Clause
// The robot and its scenario as a MuJoCo model file (MJCF).
#pragma once

#include <string>

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// Bodies "b<link>", joints and actuators "j<joint>", sensors "imu<i>_gyro", "imu<i>_accelerometer", "wrench<i>_force",
// "wrench<i>_torque". Soles touch ground and obstacles, nothing else touches. Throws InputError naming what of the
// scenario this engine cannot do.
std::string make_mjcf(const RobotDescription& robot, const Scenario& scenario);

}  // namespace hrp
