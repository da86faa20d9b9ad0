// SPDX-License-Identifier: BSD-3-Clause
// Variations of masses and pose that a scenario asks for.
#pragma once

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// The robot with each link's mass and inertia scaled as Scenario::variation says; the same without one.
RobotDescription vary_robot(const RobotDescription& robot, const Scenario& scenario);
// The scenario with its initial joint positions moved as Scenario::variation says. Only joints that the scenario
// places.
Scenario vary_scenario(const RobotDescription& robot, const Scenario& scenario);

}  // namespace hrp
