// SPDX-License-Identifier: BSD-3-Clause
// Scenes of the tests of vision: a robot that stands still, a world in YAML, and what is seen of both.
#pragma once

#include <string>

#include "common/multibody/kinematics.h"
#include "servers/model_parser/robot_loader.h"
#include "servers/vision/picture_maker.h"

namespace hrp {

// A base that is fixed to the world and an arm of 1 m that turns about its z axis. At its end a ball of radius 0.1 m.
inline const char kArm[] = R"(<robot name="arm">
  <material name="red"><color rgba="0.8 0.1 0.1 1"/></material>
  <link name="base"/>
  <link name="arm">
    <inertial><origin xyz="0.5 0 0"/><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
    <visual><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry><material name="red"/></visual>
    <collision><geometry><box size="5 5 5"/></geometry></collision>
  </link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>)";

struct SeenScene {
  // `world`: YAML beside the robot: sensors, ground, obstacles.
  explicit SeenScene(const std::string& world, const std::string& urdf = kArm)
      : scenario(
            parse_scenario("robot: arm.urdf\nbase: fixed\nservo: {default: {kp: 1, kd: 1}}\n" + world, "scene.yaml")),
        robot(parse_robot(urdf, "arm.urdf", scenario)),
        maker(robot, scenario) {
    look.state = make_state(Model(robot.tree));
    for (const ObjectSpec& object : scenario.objects) {
      State state;
      state.R_WB = Eigen::Quaterniond(object.X_WO.R);
      state.p_WB = object.X_WO.p;
      look.objects.push_back(state);
    }
    for (size_t i = 0; i < maker.num_sensors(); ++i) look.sensors.push_back(i);
  }
  const LookResult& see(double turn = 0.0, uint64_t step = 0) {
    look.state.q[0] = turn;
    look.step = step;
    maker.look(look, &result);
    return result;
  }

  Scenario scenario;
  RobotDescription robot;
  PictureMaker maker;
  Look look;
  LookResult result;
};

}  // namespace hrp
