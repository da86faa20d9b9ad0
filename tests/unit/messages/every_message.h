// SPDX-License-Identifier: BSD-3-Clause
// Every type that travels on a topic, for tests that claim something of each.
#pragma once

#include <string>
#include <vector>

#include "common/messages/cdr.h"
#include "hrp_idl/collision.h"
#include "hrp_idl/control.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/model.h"
#include "hrp_idl/ros_services.h"
#include "hrp_idl/ros_views.h"
#include "hrp_idl/scheduling.h"
#include "hrp_idl/view.h"
#include "hrp_idl/vision.h"

namespace hrp {

struct MessageCase {
  std::string type_name;
  // Decodes into the C++ type and encodes again.
  std::vector<uint8_t> (*encode_again)(Bytes sample);
};

template <typename Message>
std::vector<uint8_t> encode_again(Bytes sample) {
  Message message;
  decode(sample, &message);
  std::vector<char> buffer(7, 'x');  // dirty memory: gaps must not show it
  const Bytes bytes = encode(message, &buffer);
  return std::vector<uint8_t>(bytes.data, bytes.data + bytes.size);
}

inline const std::vector<MessageCase>& find_every_message() {
  static const std::vector<MessageCase> cases{
      {"hrp::msg::RobotDescription", encode_again<msg::RobotDescription>},
      {"hrp::msg::ModelRefused", encode_again<msg::ModelRefused>},
      {"hrp::msg::RobotState", encode_again<msg::RobotState>},
      {"hrp::msg::SensorData", encode_again<msg::SensorData>},
      {"hrp::msg::ContactSet", encode_again<msg::ContactSet>},
      {"hrp::msg::ContactForces", encode_again<msg::ContactForces>},
      {"hrp::msg::JointCommands", encode_again<msg::JointCommands>},
      {"hrp::msg::RobotEvent", encode_again<msg::RobotEvent>},
      {"hrp::msg::ServerStatus", encode_again<msg::ServerStatus>},
      {"hrp::msg::StepGrant", encode_again<msg::StepGrant>},
      {"hrp::msg::RunControl", encode_again<msg::RunControl>},
      {"hrp::msg::RunStatus", encode_again<msg::RunStatus>},
      {"hrp::msg::View", encode_again<msg::View>},
      {"hrp::msg::Pictures", encode_again<msg::Pictures>},
      {"sensor_msgs::msg::dds_::Image_", encode_again<::sensor_msgs::msg::dds_::Image_>},
      {"sensor_msgs::msg::dds_::CameraInfo_", encode_again<::sensor_msgs::msg::dds_::CameraInfo_>},
      {"sensor_msgs::msg::dds_::PointCloud2_", encode_again<::sensor_msgs::msg::dds_::PointCloud2_>},
      {"sensor_msgs::msg::dds_::JointState_", encode_again<::sensor_msgs::msg::dds_::JointState_>},
      {"sensor_msgs::msg::dds_::Imu_", encode_again<::sensor_msgs::msg::dds_::Imu_>},
      {"geometry_msgs::msg::dds_::WrenchStamped_", encode_again<::geometry_msgs::msg::dds_::WrenchStamped_>},
      {"trajectory_msgs::msg::dds_::JointTrajectory_", encode_again<::trajectory_msgs::msg::dds_::JointTrajectory_>},
      {"std_msgs::msg::dds_::Float64MultiArray_", encode_again<::std_msgs::msg::dds_::Float64MultiArray_>},
      {"std_srvs::srv::dds_::Trigger_Request_", encode_again<::std_srvs::srv::dds_::Trigger_Request_>},
      {"std_srvs::srv::dds_::Trigger_Response_", encode_again<::std_srvs::srv::dds_::Trigger_Response_>},
      {"std_srvs::srv::dds_::SetBool_Request_", encode_again<::std_srvs::srv::dds_::SetBool_Request_>},
      {"std_srvs::srv::dds_::SetBool_Response_", encode_again<::std_srvs::srv::dds_::SetBool_Response_>},
  };
  return cases;
}

}  // namespace hrp
