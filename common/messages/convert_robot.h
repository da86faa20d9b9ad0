// SPDX-License-Identifier: BSD-3-Clause
// RobotDescription <-> its message.
#pragma once

#include "common/robot/robot_description.h"
#include "hrp_idl/model.h"

namespace hrp {

// Throws InputError: a surface that cannot be used.
Surface from_message(const msg::SurfaceDescription& message);

void to_message(const RobotDescription& robot, msg::RobotDescription* message);
// Throws InputError when the tree or a shape refers to something that is not there.
void from_message(const msg::RobotDescription& message, RobotDescription* robot);

}  // namespace hrp
