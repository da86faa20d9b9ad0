// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/node.h"

#include "common/messages/convert_robot.h"
#include "common/messages/topics.h"

namespace hrp {

CollisionCheckerNode::CollisionCheckerNode(const NodeContext& context)
    : NodeBase(context), publisher_(bus(), topics::kContactSet), view_(bus()) {
  listen<msg::RobotState>(topics::kRobotState, [this](const msg::RobotState& m) { take_state(m); });
  listen<msg::RobotDescription>(topics::kRobotDescription,
                                [this](const msg::RobotDescription& m) { take_description(m); });
}

void CollisionCheckerNode::take_description(const msg::RobotDescription& message) {
  if (world_) return;
  from_message(message, &robot_);
  const Scenario scenario = parse_scenario(robot_.scenario, robot_.scenario_path);
  names_ = BodyNames(robot_, scenario);
  world_ = std::make_unique<CollisionWorld>(robot_, scenario);
}

void CollisionCheckerNode::take_state(const msg::RobotState& message) {
  if (!world_) return;  // it will be asked again
  const uint64_t epoch = message.header().epoch(), step = message.header().step();
  switch (questions_.classify(epoch, step)) {
    case Question::kOld: return;
    case Question::kRepeated: return publisher_.publish_bytes(last_answer_);
    case Question::kNew: break;
  }
  from_message(message, &state_);
  from_message(message, &objects_);
  if (state_.q.size() != robot_.tree.num_joints()) {
    return fail("robot_state of step " + std::to_string(step) + " has " + std::to_string(state_.q.size()) +
                " joints, the robot has " + std::to_string(robot_.tree.num_joints()));
  }
  const std::string wrong = find_wrong_states(world_->movers(), objects_);
  if (!wrong.empty()) return fail("robot_state of step " + std::to_string(step) + " has " + wrong);
  to_message(world_->calc_contacts(state_, objects_), names_, &answer_);
  answer_.header(message.header());
  last_answer_ = publisher_.publish(answer_);
  if (view_.is_due()) view_.add(topics::kContactSet.name, last_answer_);
  questions_.note_answered(epoch, step);
  set_phase(msg::SERVER_READY);
}

std::string CollisionCheckerNode::find_missing() const {
  if (!world_) return "robot_description from model_parser";
  return status().phase() == msg::SERVER_READY ? "" : "robot_state from dynamics";
}

void CollisionCheckerNode::handle_idle(Clock::time_point now) {
  if (view_.update(now)) view_.add(topics::kContactSet.name, last_answer_);
}

}  // namespace hrp
