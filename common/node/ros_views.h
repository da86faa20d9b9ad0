// SPDX-License-Identifier: BSD-3-Clause
// What ros2 tools see of a run: clock, frames, URDF, joint states, IMUs, foot wrenches under ROS names. Streams are sent
// only while somebody reads them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/messages/pubsub.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/scene/frames.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/ros_views.h"

namespace hrp {

// Empty when RosViews can have this rate, else what was expected.
std::string find_ros_rate_fault(double rate);

class RosViews {
 public:
  RosViews() = default;  // publishes nothing
  // Sends what is kept for late readers: URDF and fixed frames.
  // `rate` [1/s of simulated time] of joint states and frames; 0: every control period, as all others.
  RosViews(Bus& bus, const RobotDescription& robot, const SensorsSpec& sensors, double rate = 0.0);
  // Asks the bus who reads; not on every step, it costs a lock.
  void update_readers();
  // Once per control period.
  void publish(const msg::SensorData& sensors, const State& state);

 private:
  template <typename Message>
  struct View {
    Publisher<Message> publisher;
    Message message;
    bool wanted = false;
  };
  // The first sample at or after each multiple of 1 / rate.
  bool is_due(double time);
  void publish_clock(double time);
  void publish_frames(double time, const State& state);
  void publish_joint_states(const msg::SensorData& sensors);

  std::vector<View<rosgraph_msgs::msg::dds_::Clock_>> clock_;            // none or one
  std::vector<View<tf2_msgs::msg::dds_::TFMessage_>> tf_;                // none or one
  Publisher<tf2_msgs::msg::dds_::TFMessage_> tf_static_;
  Publisher<std_msgs::msg::dds_::String_> robot_description_;
  std::unique_ptr<FrameTree> tree_;
  std::vector<NamedTransform> moving_;
  std::vector<View<sensor_msgs::msg::dds_::JointState_>> joint_states_;  // none or one
  std::vector<View<sensor_msgs::msg::dds_::Imu_>> imus_;
  std::vector<View<geometry_msgs::msg::dds_::WrenchStamped_>> wrenches_;
  double rate_ = 0.0;
  double last_multiple_ = -1.0;
};

}  // namespace hrp
