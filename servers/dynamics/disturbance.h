// SPDX-License-Identifier: BSD-3-Clause
// What a scenario does to a robot that the robot's description does not say: variations of masses and pose, pushes.
#pragma once

#include "common/multibody/kinematics.h"
#include "servers/dynamics/simulator.h"

namespace hrp {

// The robot with each link's mass and inertia scaled as Scenario::variation says; the same without one.
RobotDescription vary_robot(const RobotDescription& robot, const Scenario& scenario);
// The scenario with its initial joint positions moved as Scenario::variation says. Only joints that the scenario places.
Scenario vary_scenario(const RobotDescription& robot, const Scenario& scenario);

// Scenario::pushes as wrenches.
class Pushes {
 public:
  // Throws InputError: unknown link.
  Pushes(const TreeSpec& tree, const Scenario& scenario);
  // Those that act in the step that begins at `time`. The result lives until the next call.
  const ExternalWrenches& find(double time, const State& state);

 private:
  struct Push {
    int link = 0;
    PushSpec spec;
  };
  std::vector<Push> pushes_;
  Model model_;
  Data data_;
  ExternalWrenches active_;
};

}  // namespace hrp
