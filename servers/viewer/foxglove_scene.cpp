// SPDX-License-Identifier: BSD-3-Clause
#include "servers/viewer/foxglove_scene.h"

#include "common/messages/convert.h"
#include "common/messages/convert_robot.h"
#include "common/messages/logged_description.h"
#include "common/messages/topics.h"
#include "common/scene/foxglove.h"

namespace hrp {

struct FoxgloveScene::Robot {
  explicit Robot(const RobotDescription& robot) {
    try {
      scene = std::make_unique<foxglove::Scene>(robot, parse_scenario(robot.scenario, robot.scenario_path));
      world = scene->make_world(0.0);
    } catch (const std::exception&) {
      // A robot without a scenario that we understand still moves.
      RobotDescription alone = robot;
      alone.robots.clear();
      scene = std::make_unique<foxglove::Scene>(alone, Scenario());
    }
    std::vector<std::string> unread;  // meshes that cannot be read are shown by nobody
    shapes = scene->make_robots(0.0, &unread);
    fixed = scene->make_fixed_transforms(0.0);
  }
  std::unique_ptr<foxglove::Scene> scene;
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
      {"/scene/contacts", foxglove::kSceneUpdate, topics::kContactForces.name},
      {"/scene/pushes", foxglove::kSceneUpdate, topics::kRobotState.name}};
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
      return robot_->scene->make_contacts(forces, time);
    }
    msg::RobotState message;
    decode_logged(source, &message);
    State state;
    ObjectStates others;
    from_message(message, &state);
    from_message(message, &others);
    if (channel.topic == "/scene/pushes") {
      PushForces pushes;
      from_message(message, &pushes);
      return robot_->scene->make_pushes(state, others, pushes, time);
    }
    return robot_->scene->make_transforms(state, others, time);
  } catch (const std::exception&) {
    return "";
  }
}

}  // namespace hrp
