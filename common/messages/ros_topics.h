// SPDX-License-Identifier: BSD-3-Clause
// Topics that tools of ROS 2 expect of any robot, as rmw names them on DDS.
#pragma once

#include "common/messages/topics.h"

namespace hrp::topics {

inline const TopicSpec kRosClock{"rt/clock", "rosgraph_msgs::msg::dds_::Clock_", Retention::kStream, 16};
inline const TopicSpec kRosTf{"rt/tf", "tf2_msgs::msg::dds_::TFMessage_", Retention::kStream, 128};
inline const TopicSpec kRosTfStatic{"rt/tf_static", "tf2_msgs::msg::dds_::TFMessage_", Retention::kLatest, 1};
inline const TopicSpec kRosRobotDescription{"rt/robot_description", "std_msgs::msg::dds_::String_", Retention::kLatest,
                                            1};
// Commands to the robot, read by hrp-controller-ros.
inline const TopicSpec kRosJointTrajectory{"rt/joint_trajectory", "trajectory_msgs::msg::dds_::JointTrajectory_",
                                           Retention::kStream, 16};
inline const TopicSpec kRosPositionCommands{"rt/position_commands", "std_msgs::msg::dds_::Float64MultiArray_",
                                            Retention::kStream, 16};

// Of a camera or a lidar of this name.
inline TopicSpec make_color_image_topic(const std::string& camera) {
  return {"rt/" + camera + "/image_raw", "sensor_msgs::msg::dds_::Image_", Retention::kStream, 4};
}
inline TopicSpec make_depth_image_topic(const std::string& camera) {
  return {"rt/" + camera + "/depth/image_raw", "sensor_msgs::msg::dds_::Image_", Retention::kStream, 4};
}
inline TopicSpec make_camera_info_topic(const std::string& camera) {
  return {"rt/" + camera + "/camera_info", "sensor_msgs::msg::dds_::CameraInfo_", Retention::kStream, 4};
}
inline TopicSpec make_points_topic(const std::string& lidar) {
  return {"rt/" + lidar + "/points", "sensor_msgs::msg::dds_::PointCloud2_", Retention::kStream, 4};
}

// Services that steer a run, offered by the scheduler with --ros-services.
inline const ServiceSpec kRosPause{"run/pause", "std_srvs::srv::dds_::SetBool"};
inline const ServiceSpec kRosResume{"run/resume", "std_srvs::srv::dds_::Trigger"};
inline const ServiceSpec kRosStep{"run/step", "std_srvs::srv::dds_::Trigger"};
inline const ServiceSpec kRosReset{"run/reset", "std_srvs::srv::dds_::Trigger"};

// Those above that each robot has of its own.
inline const TopicSpec* const kRosOfRobot[] = {&kRosRobotDescription, &kRosJointTrajectory, &kRosPositionCommands};

// As find_known_topic(), these included.
inline const TopicSpec* find_any_topic(const std::string& name) {
  for (const TopicSpec* topic : {&kRosClock, &kRosTf, &kRosTfStatic}) {
    if (topic->name == name) return topic;
  }
  for (const TopicSpec* topic : kRosOfRobot) {
    if (topic->name == name || topic->name == drop_robot(name)) return topic;
  }
  static const TopicSpec kAnyImage = make_color_image_topic("<camera>"), kAnyInfo = make_camera_info_topic("<camera>"),
                         kAnyPoints = make_points_topic("<lidar>");
  const auto ends_with = [&](const std::string& end) {
    return !find_ros_topic(name).empty() && name.size() > end.size() &&
           name.compare(name.size() - end.size(), end.size(), end) == 0;
  };
  if (ends_with("/image_raw")) return &kAnyImage;
  if (ends_with("/camera_info")) return &kAnyInfo;
  if (ends_with("/points")) return &kAnyPoints;
  return find_known_topic(name);
}

}  // namespace hrp::topics
