// SPDX-License-Identifier: BSD-3-Clause
// A controller that does what nodes of ROS 2 tell it: rt/joint_trajectory and rt/position_commands.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "controller/node.h"
#include "controller/ros/command_input.h"

namespace hrp {

// Holds the initial pose until it is told something. One that joins a run that goes on holds the measured pose.
class RosController : public Controller {
 public:
  explicit RosController(const Robot& robot);
  // Replaces what was to be done, from the last command on. Throws InputError and goes on as before when the message
  // cannot be.
  void take(const RosJointTrajectory& message);
  void take(const RosPositions& message);

  void start(const Robot& robot) override;
  JointCommand control(const SensorData& sensors, const Robot& robot) override;
  std::unique_ptr<Controller> clone() const override { return std::make_unique<RosController>(*this); }

 private:
  void hold(const Eigen::VectorXd& q);
  void begin(Trajectory trajectory);

  Robot robot_;
  JointCommand command_;               // the last one
  std::optional<double> time_;         // [s] when it was given
  Trajectory trajectory_;
  std::optional<double> begin_;        // [s] of the trajectory; none: with the first sample
  bool told_ = false;                  // a message was taken since the start
};

class RosControllerNode : public ControllerNode {
 public:
  explicit RosControllerNode(const NodeContext& context);

 protected:
  void handle_idle(Clock::time_point now) override;
  void handle_decode_error(const std::string& topic, const std::string& reason) override;

 private:
  template <typename Message>
  void listen_for(const TopicSpec& topic);
  void note_refused(const std::string& reason);

  RosController* controller_ = nullptr;  // of the base; none until the robot is known
  std::deque<std::string> refused_;      // lines to be said
  uint64_t num_refused_ = 0;
  Clock::time_point said_{};
};

}  // namespace hrp
