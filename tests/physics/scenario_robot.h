// SPDX-License-Identifier: BSD-3-Clause
// A robot as the servers see it, made from scenario text: loader, collision checker and physics core without a bus.
#pragma once

#include <string>

#include "servers/collision_checker/collision_world.h"
#include "servers/dynamics/simulator.h"
#include "servers/model_parser/robot_loader.h"
#include "tests/test_places.h"

namespace hrp {

class ScenarioRobot {
 public:
  explicit ScenarioRobot(const std::string& yaml)
      : robot(load_robot(parse_scenario(yaml, source_dir() + "/models/scenarios/test.yaml"))),
        scenario(parse_scenario(robot.scenario, robot.scenario_path)),
        world(robot, scenario),
        simulator(robot, scenario) {
    command.q = simulator.state().q;
  }
  StepStatus step(const ExternalWrenches& pushes = {}) {
    return simulator.step(world.calc_contacts(simulator.state()), command, pushes);
  }

  RobotDescription robot;
  Scenario scenario;  // as the model parser hands it on
  CollisionWorld world;
  Simulator simulator;
  JointCommand command;
};

}  // namespace hrp
