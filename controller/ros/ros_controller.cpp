// SPDX-License-Identifier: BSD-3-Clause
#include "controller/ros/ros_controller.h"

#include "common/base/diagnostics.h"
#include "common/messages/ros_topics.h"

namespace hrp {
namespace {

// Somebody may send a thousand a second: so many lines about refused messages wait at most, and this long in between.
constexpr size_t kMostLines = 4;
constexpr auto kBetweenLines = std::chrono::milliseconds(250);  // of wall clock

}  // namespace

RosController::RosController(const Robot& robot) : robot_(robot) { hold(robot.initial_q); }

void RosController::hold(const Eigen::VectorXd& q) {
  command_.q = q;
  command_.qd.setZero(q.size());
  command_.effort.setZero(q.size());
  trajectory_ = make_hold(command_);
  begin_.reset();
  told_ = false;
}

void RosController::begin(Trajectory trajectory) {
  trajectory_ = std::move(trajectory);
  begin_ = time_;
  told_ = true;
}

void RosController::take(const RosJointTrajectory& message) { begin(make_trajectory(message, robot_, command_)); }

void RosController::take(const RosPositions& message) { begin(make_trajectory(message, robot_)); }

// What came before the first sample is not forgotten, what came before a reset is.
void RosController::start(const Robot& robot) {
  if (time_) hold(robot.initial_q);
  time_.reset();
}

JointCommand RosController::control(const SensorData& sensors, const Robot&) {
  if (!time_ && sensors.time > 0.0 && !told_) hold(sensors.q);
  time_ = sensors.time;
  if (!begin_) begin_ = time_;
  return command_ = trajectory_.sample(*time_ - *begin_);
}

RosControllerNode::RosControllerNode(const NodeContext& context)
    : ControllerNode(context, [this](const Robot& robot) {
        auto controller = std::make_unique<RosController>(robot);
        controller_ = controller.get();
        return controller;
      }) {
  listen_for<RosJointTrajectory>(topics::kRosJointTrajectory);
  listen_for<RosPositions>(topics::kRosPositionCommands);
}

template <typename Message>
void RosControllerNode::listen_for(const TopicSpec& topic) {
  listen<Message>(topic, [this, name = topic.name](const Message& message) {
    if (!controller_) return note_refused(name + ": came before the robot was known; send it again");
    try {
      controller_->take(message);
    } catch (const InputError& error) {
      note_refused(error.what());
    }
  });
}

// Others can send what they like on these topics; that ends no run.
void RosControllerNode::handle_decode_error(const std::string& topic, const std::string& reason) {
  if (topic == topics::kRosJointTrajectory.name || topic == topics::kRosPositionCommands.name) return note_refused(topic + ": " + reason);
  ControllerNode::handle_decode_error(topic, reason);
}

// The count makes each line a new one, as equal lines are shown once a run, and tells how many were left out.
void RosControllerNode::note_refused(const std::string& reason) {
  ++num_refused_;
  if (refused_.size() == kMostLines) return;
  refused_.push_back("refused, goes on as before: " + reason + " (" + std::to_string(num_refused_) + " refused so far)");
}

void RosControllerNode::handle_idle(Clock::time_point now) {
  ControllerNode::handle_idle(now);
  if (refused_.empty() || now - said_ < kBetweenLines) return;
  said_ = now;
  say(refused_.front());
  refused_.pop_front();
}

}  // namespace hrp
