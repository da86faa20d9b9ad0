// SPDX-License-Identifier: BSD-3-Clause
// What ros2 tools see of a run: joint states, IMUs, foot wrenches under ROS names. Sent only while somebody reads them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/messages/pubsub.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/ros_views.h"

namespace hrp {

class RosViews {
 public:
  RosViews() = default;  // publishes nothing
  RosViews(Bus& bus, const TreeSpec& tree, const SensorsSpec& sensors);
  // Asks the bus who reads; not on every step, it costs a lock.
  void update_readers();
  void publish(const msg::SensorData& sensors);

 private:
  template <typename Message>
  struct View {
    Publisher<Message> publisher;
    Message message;
    bool wanted = false;
  };

  std::vector<View<sensor_msgs::msg::dds_::JointState_>> joint_states_;  // none or one
  std::vector<View<sensor_msgs::msg::dds_::Imu_>> imus_;
  std::vector<View<geometry_msgs::msg::dds_::WrenchStamped_>> wrenches_;
};

}  // namespace hrp
