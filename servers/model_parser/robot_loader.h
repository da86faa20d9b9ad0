// SPDX-License-Identifier: BSD-3-Clause
// Scenario -> robot description: the core of the model parser.
#pragma once

#include <string>

#include "common/base/diagnostics.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// How the warning about a missing mesh ends when the robot is simulated without it.
constexpr char kWithoutMesh[] = "; simulated without it";

// Loads the robot that `scenario` names, a URDF, MJCF or SDF file, and checks the scenario against it. Throws
// InputError with everything that is wrong: file, line, element, reason. What was repaired, ignored or missing stands
// in RobotDescription::warnings.
RobotDescription load_robot(const Scenario& scenario);

// The same from text that was read from `path`. MJCF and SDF become a URDF, which is what the description holds.
RobotDescription parse_robot(const std::string& text, const std::string& path, const Scenario& scenario);

}  // namespace hrp
