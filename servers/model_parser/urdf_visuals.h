// SPDX-License-Identifier: BSD-3-Clause
// What a robot looks like. Nothing here refuses a robot: a drawing that cannot be read is left out.
#pragma once

#include <string>
#include <vector>

#include "common/robot/robot_description.h"

namespace hrp {

// The <visual> shapes of each link in the colour of their <material>. A link without a usable one shows its collision
// shapes, which robot.shapes holds; frames and shapes of `robot` are filled.
std::vector<VisualShape> read_visuals(const std::string& urdf, const RobotDescription& robot);

}  // namespace hrp
