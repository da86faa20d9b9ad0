// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/base/diagnostics.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// Every link and joint that the scenario names is one of the robot's; adds errors that point into the scenario file.
void check_scenario(const Scenario& scenario, const RobotDescription& robot, Diagnostics* diagnostics);

// The same of the bodies that the scenario pushes; links of other robots count once they are in `robot`.
void check_pushes(const Scenario& scenario, const RobotDescription& robot, Diagnostics* diagnostics);

}  // namespace hrp
