// SPDX-License-Identifier: BSD-3-Clause
// A controller that does what nodes of ROS 2 tell it: rt/joint_trajectory and rt/position_commands; of robot "partner",
// rt/partner/joint_trajectory and rt/partner/position_commands.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "controller/node.h"
#include "controller/ros/command_input.h"

namespace hrp {

// Joints that no message has named follow another controller: that of the scenario. Where that one holds the initial
// pose, one that joins a run that goes on holds the measured pose.
class RosController : public Controller {
 public:
  // `name`: of the robot beside others, whose topics its errors name.
  RosController(const Robot& robot, std::unique_ptr<Controller> other, const std::string& name = "");
  // Replaces what was to be done, from the last command on. Throws InputError and goes on as before when the message
  // cannot be.
  void take(const RosJointTrajectory& message);
  void take(const RosPositions& message);
  // What was taken before the first sample and cannot be from the pose that it shows; each is told once.
  std::vector<std::string> take_refused();

  void start(const Robot& robot) override;
  JointCommand control(const SensorData& sensors, const Robot& robot) override;

 private:
  void forget();
  void begin(Trajectory trajectory);
  // Before the first sample, keeps the message for it. Throws InputError where too many wait.
  template <typename Message>
  bool keep_early(const Message& message, const std::string& topic);
  void take_early();
  void take_all_joints() { told_.assign(robot_.joints.size(), true); }

  Robot robot_;
  std::unique_ptr<Controller> other_;
  TopicSpec trajectory_topic_, positions_topic_;
  JointCommand command_;                      // the last one; all its arrays have one number a joint
  std::optional<double> time_;                // [s] when it was given
  std::vector<bool> told_;                    // joints that follow the trajectory
  Trajectory trajectory_;                     // of all joints
  std::optional<double> begin_;               // [s] of the trajectory; none: with the first sample
  std::vector<std::function<void()>> early_;  // take what came before the first sample, from the pose that it shows
  std::vector<std::string> refused_;          // take_refused()
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
  template <typename Message>
  void take(const Message& message);
  void note_refused(const std::string& reason);

  RosController* controller_ = nullptr;       // of the base; none until the robot is known
  std::vector<std::function<void()>> early_;  // take what came before that, in its order
  std::deque<std::string> refused_;           // lines to be said
  uint64_t num_refused_ = 0;
  Clock::time_point said_{};
};

}  // namespace hrp
