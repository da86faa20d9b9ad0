// SPDX-License-Identifier: BSD-3-Clause
// What cameras and lidars have seen -> messages of ROS 2. Targets keep their memory.
#pragma once

#include "common/bus/bus.h"
#include "hrp_idl/ros_views.h"
#include "servers/vision/camera.h"
#include "servers/vision/lidar.h"

namespace hrp {

using RosImage = ::sensor_msgs::msg::dds_::Image_;
using RosCameraInfo = ::sensor_msgs::msg::dds_::CameraInfo_;
using RosPointCloud = ::sensor_msgs::msg::dds_::PointCloud2_;

// `time` [s]: simulated.
void set_camera_info(const CameraSpec& camera, double time, RosCameraInfo* ros);
// rgb8.
void set_color_image(const CameraSpec& camera, const CameraPicture& picture, double time, RosImage* ros);
// 32FC1.
void set_depth_image(const CameraSpec& camera, const CameraPicture& picture, double time, RosImage* ros);
void set_points(const LidarSpec& lidar, const Points& points, double time, RosPointCloud* ros);

}  // namespace hrp
