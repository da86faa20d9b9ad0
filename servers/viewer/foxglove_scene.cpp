// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/foxglove_scene.h"

#include "common/messages/logged_description.h"
#include "common/messages/convert.h"
#include "common/messages/convert_robot.h"
#include "common/messages/topics.h"
#include "common/multibody/model.h"
#include "common/scene/foxglove.h"

namespace hrp {

struct FoxgloveScene::Robot {
  explicit Robot(const RobotDescription& robot) : frames(robot.tree) {
    arrow_scale = foxglove::calc_arrow_scale(Model(robot.tree).mass());
    std::vector<std::string> unread;  // meshes that cannot be read are shown by nobody
    shapes = foxglove::make_robot(robot, frames, 0.0, &unread);
    SensorsSpec sensors;
    try {
      const Scenario scenario = parse_scenario(robot.scenario, robot.scenario_path);
      sensors = scenario.sensors;
      ground = make_ground_plane(scenario.ground);
      world = foxglove::make_world(robot, scenario, frames, 0.0);
    } catch (const std::exception&) {
      // A robot without a scenario that we understand still moves.
    }
    fixed = foxglove::make_transforms(frames.make_fixed(sensors), 0.0);
  }
  FrameTree frames;
  GroundPlane ground;
  double arrow_scale = 0.0;  // [m/N]
  std::string shapes, fixed, world;
};

FoxgloveScene::FoxgloveScene() = default;
FoxgloveScene::~FoxgloveScene() = default;

const std::vector<FoxgloveScene::Channel>& FoxgloveScene::channels() {
  static const std::vector<Channel> all{
      {"/transforms/fixed", foxglove::kFrameTransforms, topics::kRobotDescription.name},
      {"/scene/robot", foxglove::kSceneUpdate, topics::kRobotDescription.name},
      {"/scene/world", foxglove::kSceneUpdate, topics::kRobotDescription.name},
      {"/transforms", foxglove::kFrameTransforms, topics::kRobotState.name},
      {"/scene/contacts", foxglove::kSceneUpdate, topics::kContactForces.name}};
  return all;
}

void FoxgloveScene::set_robot(const msg::RobotDescription& description) {
  robot_.reset();
  try {
    RobotDescription robot;
    from_message(description, &robot);
    robot_ = std::make_unique<Robot>(robot);
  } catch (const std::exception&) {
    // Of a robot that makes no sense there is nothing to draw.
  }
}

std::string FoxgloveScene::make(const Channel& channel, double time, Bytes source) const {
  if (!robot_) return "";
  if (channel.topic == "/transforms/fixed") return robot_->fixed;
  if (channel.topic == "/scene/robot") return robot_->shapes;
  if (channel.topic == "/scene/world") return robot_->world;
  try {
    if (channel.topic == "/scene/contacts") {
      msg::ContactForces message;
      decode(source, &message);
      ContactForces forces;
      from_message(message, &forces);
      return foxglove::make_contacts(forces, robot_->frames, robot_->ground, robot_->arrow_scale, time);
    }
    msg::RobotState message;
    decode_logged(source, &message);
    State state;
    from_message(message, &state);
    std::vector<NamedTransform> moving;
    robot_->frames.update_moving(state, &moving);
    return foxglove::make_transforms(moving, time);
  } catch (const std::exception&) {
    return "";
  }
}

}  // namespace hrp
