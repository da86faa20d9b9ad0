// SPDX-License-Identifier: BSD-3-Clause
// What ros2 tools see of a run: clock, frames, URDF, joint states, IMUs, foot wrenches under ROS names. Streams are
// sent only while somebody reads them. There is one clock and one tree of frames; all else of robot "partner" is in the
// namespace /partner, its frames are "partner/L_FOOT".
#pragma once

#include <string>
#include <vector>

#include "common/messages/pubsub.h"
#include "common/robot/movers.h"
#include "common/scene/frames.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/ros_views.h"

namespace hrp {

// Empty when RosViews can have this rate, else what was expected.
std::string find_ros_rate_fault(double rate);

// A robot at a control step.
struct RobotSample {
  const msg::SensorData* sensors = nullptr;
  const State* state = nullptr;
};

class RosViews {
 public:
  RosViews() = default;  // publishes nothing
  // Sends what is kept for late readers: URDFs and fixed frames.
  // `rate` [1/s of simulated time] of joint states and frames; 0: every control period, as all others.
  RosViews(Bus& bus, const std::vector<Mover>& robots, double rate = 0.0);
  // Asks the bus who reads; not on every step, it costs a lock.
  void update_readers();
  // Once per control period, with all robots in their order.
  void publish(const std::vector<RobotSample>& samples);

 private:
  template <typename Message>
  struct View {
    Publisher<Message> publisher;
    Message message;
    bool wanted = false;
  };
  // What is in a robot's own namespace.
  struct RobotViews {
    RobotViews(Bus& bus, const Mover& robot, const FrameTree& tree);
    void update_readers();
    void publish_joint_states(const msg::SensorData& sensors);
    void publish_sensors(const msg::SensorData& sensors);
    Publisher<std_msgs::msg::dds_::String_> description;
    View<sensor_msgs::msg::dds_::JointState_> joint_states;
    std::vector<View<sensor_msgs::msg::dds_::Imu_>> imus;
    std::vector<View<geometry_msgs::msg::dds_::WrenchStamped_>> wrenches;
  };
  // The first sample at or after each multiple of 1 / rate.
  bool is_due(double time);
  void publish_clock(double time);
  void publish_frames(double time, const std::vector<RobotSample>& samples);

  std::vector<View<rosgraph_msgs::msg::dds_::Clock_>> clock_;  // none or one
  std::vector<View<tf2_msgs::msg::dds_::TFMessage_>> tf_;      // none or one
  Publisher<tf2_msgs::msg::dds_::TFMessage_> tf_static_;
  std::vector<FrameTree> trees_;  // one a robot
  std::vector<RobotViews> robots_;
  std::vector<NamedTransform> moving_, all_moving_;
  double rate_ = 0.0;
  double last_multiple_ = -1.0;
};

}  // namespace hrp
