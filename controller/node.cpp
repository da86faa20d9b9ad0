// SPDX-License-Identifier: BSD-3-Clause
#include "controller/node.h"

#include "common/messages/convert_robot.h"
#include "common/messages/topics.h"

namespace hrp {

int Robot::find_joint(const std::string& joint) const {
  for (size_t i = 0; i < joints.size(); ++i) {
    if (joints[i] == joint) return static_cast<int>(i);
  }
  return -1;
}

Robot make_robot(const RobotDescription& description, const Scenario& scenario) {
  const TreeSpec& tree = description.tree;
  const int n = tree.num_joints();
  Robot robot;
  robot.name = tree.name;
  robot.lower.resize(n);
  robot.upper.resize(n);
  robot.effort_limit.resize(n);
  robot.initial_q.setZero(n);
  for (int i = 0; i < n; ++i) {
    const JointSpec& joint = tree.joint(i);
    robot.joints.push_back(joint.name);
    robot.lower[i] = joint.lower;
    robot.upper[i] = joint.upper;
    robot.effort_limit[i] = joint.effort_limit;
    const auto found = scenario.initial_joints.find(joint.name);
    if (found != scenario.initial_joints.end()) robot.initial_q[i] = found->second;
  }
  for (int i = 0; i < n; ++i) {
    const MimicSpec& mimic = tree.joint(i).mimic;
    if (mimic.joint >= 0) robot.initial_q[i] = mimic.multiplier * robot.initial_q[mimic.joint] + mimic.offset;
  }
  for (const ImuSpec& imu : scenario.sensors.imus) robot.imus.push_back(imu.name);
  for (const WrenchSpec& wrench : scenario.sensors.wrenches) robot.wrenches.push_back(wrench.name);
  robot.period = scenario.time_step * scenario.control_period;
  robot.gravity_W = scenario.gravity_W;
  robot.settings = scenario.controller;
  robot.sensors = scenario.sensors;
  robot.description = std::make_shared<const RobotDescription>(description);
  return robot;
}

ControllerNode::ControllerNode(const NodeContext& context, ControllerMaker make_controller)
    : NodeBase(context),
      make_controller_(std::move(make_controller)),
      commands_(topics::of_robot(topics::kJointCommands, context.robot)),
      publisher_(bus(), commands_),
      view_(bus()) {
  listen<msg::SensorData>(topics::of_robot(topics::kSensorData, context.robot),
                          [this](const msg::SensorData& m) { take_sensors(m); });
  listen<msg::RobotDescription>(topics::of_robot(topics::kRobotDescription, context.robot),
                                [this](const msg::RobotDescription& m) { take_description(m); });
}

void ControllerNode::take_description(const msg::RobotDescription& message) {
  if (controller_) return;
  RobotDescription description;
  from_message(message, &description);
  robot_ = make_robot(description, parse_scenario(description.scenario, description.scenario_path));
  controller_ = make_controller_(robot_);
}

void ControllerNode::take_sensors(const msg::SensorData& message) {
  if (!controller_) return;  // it will be asked again
  const uint64_t epoch = message.header().epoch(), step = message.header().step();
  switch (questions_.classify(epoch, step)) {
    case Question::kOld: return;
    case Question::kRepeated: return publisher_.publish_bytes(last_answer_);
    case Question::kNew: break;
  }
  if (!in_epoch_ || epoch != epoch_) controller_->start(robot_);
  in_epoch_ = true;
  epoch_ = epoch;
  from_message(message, &sensors_);
  sensors_.time = message.header().time();
  sensors_.step = step;
  to_message(controller_->control(sensors_, robot_), &answer_);
  answer_.header(message.header());
  last_answer_ = publisher_.publish(answer_);
  if (view_.is_due()) view_.add(commands_.name, last_answer_);
  questions_.note_answered(epoch, step);
  set_phase(msg::SERVER_READY);
}

std::string ControllerNode::find_missing() const {
  if (!controller_) return "robot_description from model_parser";
  return in_epoch_ ? "" : "sensor_data from dynamics";
}

void ControllerNode::handle_idle(Clock::time_point now) {
  if (view_.update(now)) view_.add(commands_.name, last_answer_);
}

}  // namespace hrp
