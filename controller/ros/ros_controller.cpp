// SPDX-License-Identifier: BSD-3-Clause
#include "controller/ros/ros_controller.h"

#include <algorithm>
#include <utility>

#include "common/base/diagnostics.h"
#include "common/messages/ros_topics.h"
#include "controller/play.h"

namespace hrp {
namespace {

// Somebody may send a thousand a second: so many lines about refused messages wait at most, and this long in between.
constexpr size_t kMostLines = 4;
constexpr auto kBetweenLines = std::chrono::milliseconds(250);  // of wall clock
// Messages kept until the robot is known, and its pose: more is no command that somebody gave once.
constexpr size_t kMostEarly = 16;

// All arrays with one number a joint.
JointCommand fill(JointCommand command) {
  if (command.qd.size() == 0) command.qd.setZero(command.q.size());
  if (command.effort.size() == 0) command.effort.setZero(command.q.size());
  return command;
}

bool holds_initial_pose(const Robot& robot) { return robot.settings.type == "hold" || robot.settings.type == "none"; }

}  // namespace

RosController::RosController(const Robot& robot, std::unique_ptr<Controller> other, const std::string& name)
    : robot_(robot),
      other_(std::move(other)),
      trajectory_topic_(topics::of_robot(topics::kRosJointTrajectory, name)),
      positions_topic_(topics::of_robot(topics::kRosPositionCommands, name)) {
  forget();
}

void RosController::forget() {
  command_ = fill({robot_.initial_q, {}, {}});
  time_.reset();
  told_.assign(robot_.joints.size(), false);
  trajectory_ = make_hold(command_);
  begin_.reset();
}

void RosController::begin(Trajectory trajectory) {
  trajectory_ = std::move(trajectory);
  begin_ = time_;
}

template <typename Message>
bool RosController::keep_early(const Message& message, const std::string& topic) {
  if (time_) return false;
  if (early_.size() == kMostEarly)
    refuse_input({topic, ""},
                 "came before the first sample, after " + std::to_string(kMostEarly) + " others; send it again");
  early_.push_back([this, message] { take(message); });
  return true;
}

void RosController::take_early() {
  for (const auto& take_message : std::exchange(early_, {})) {
    try {
      take_message();
    } catch (const InputError& error) {  // from the initial pose it could be
      refused_.push_back(error.what());
    }
  }
}

std::vector<std::string> RosController::take_refused() { return std::exchange(refused_, {}); }

void RosController::take(const RosJointTrajectory& message) {
  Trajectory trajectory = make_trajectory(message, robot_, command_, trajectory_topic_.name);
  if (keep_early(message, trajectory_topic_.name)) return;
  begin(std::move(trajectory));
  if (message.points().empty()) take_all_joints();
  for (const std::string& name : message.joint_names()) told_[static_cast<size_t>(robot_.find_joint(name))] = true;
}

void RosController::take(const RosPositions& message) {
  Trajectory trajectory = make_trajectory(message, robot_, positions_topic_.name);
  if (keep_early(message, positions_topic_.name)) return;
  begin(std::move(trajectory));
  take_all_joints();
}

// What came before the first sample is not forgotten, what came before a reset is.
void RosController::start(const Robot& robot) {
  if (time_) forget();
  other_->start(robot);
}

JointCommand RosController::control(const SensorData& sensors, const Robot& robot) {
  const JointCommand others = other_->control(sensors, robot);
  const bool joins = !time_ && sensors.time > 0.0 && holds_initial_pose(robot_);
  time_ = sensors.time;
  if (!begin_) begin_ = time_;
  if (joins) {
    command_ = fill({sensors.q, {}, {}});
    trajectory_ = make_hold(command_);
    take_all_joints();
  }
  take_early();
  command_ = fill(others);
  const JointCommand told = trajectory_.sample(*time_ - *begin_);
  for (size_t k = 0; k < told_.size(); ++k) {
    const auto joint = static_cast<Eigen::Index>(k);
    if (!told_[k]) continue;
    command_.q[joint] = told.q[joint];
    command_.qd[joint] = told.qd[joint];
    command_.effort[joint] = told.effort[joint];
  }
  return command_;
}

RosControllerNode::RosControllerNode(const NodeContext& context)
    : ControllerNode(context, [this, name = context.robot](const Robot& robot) {
        auto controller = std::make_unique<RosController>(robot, make_scenario_controller(robot), name);
        controller_ = controller.get();
        for (const auto& take_message : std::exchange(early_, {})) take_message();
        return controller;
      }) {
  listen_for<RosJointTrajectory>(topics::of_robot(topics::kRosJointTrajectory, context.robot));
  listen_for<RosPositions>(topics::of_robot(topics::kRosPositionCommands, context.robot));
}

template <typename Message>
void RosControllerNode::listen_for(const TopicSpec& topic) {
  listen<Message>(topic, [this, name = topic.name](const Message& message) {
    if (controller_) return take(message);
    if (early_.size() == kMostEarly)
      return note_refused(name + ": came before the robot was known, after " + std::to_string(kMostEarly) +
                          " others; send it again");
    early_.push_back([this, message] { take(message); });
  });
}

template <typename Message>
void RosControllerNode::take(const Message& message) {
  try {
    controller_->take(message);
  } catch (const InputError& error) {
    note_refused(error.what());
  }
}

// Others can send what they like on these topics; that ends no run.
void RosControllerNode::handle_decode_error(const std::string& topic, const std::string& reason) {
  if (!topics::find_ros_topic(topic).empty()) return note_refused(topic + ": " + reason);
  ControllerNode::handle_decode_error(topic, reason);
}

// The count makes each line a new one, as equal lines are shown once a run, and tells how many were left out.
void RosControllerNode::note_refused(const std::string& reason) {
  ++num_refused_;
  if (refused_.size() == kMostLines) return;
  refused_.push_back("refused, goes on as before: " + reason + " (" + std::to_string(num_refused_) +
                     " refused so far)");
}

void RosControllerNode::handle_idle(Clock::time_point now) {
  ControllerNode::handle_idle(now);
  for (const std::string& reason : controller_ ? controller_->take_refused() : std::vector<std::string>())
    note_refused(reason);
  if (refused_.empty() || now - said_ < kBetweenLines) return;
  said_ = now;
  say(refused_.front());
  refused_.pop_front();
}

}  // namespace hrp
