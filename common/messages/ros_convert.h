// SPDX-License-Identifier: BSD-3-Clause
// Messages of a run -> messages of ROS 2. Targets keep their memory.
#pragma once

#include <string>
#include <vector>

#include "common/scene/frames.h"
#include "common/spatial/transform.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/ros_views.h"

namespace hrp::ros {

namespace geometry = ::geometry_msgs::msg::dds_;
namespace sensor = ::sensor_msgs::msg::dds_;
namespace standard = ::std_msgs::msg::dds_;

// `time` [s]: simulated.
void set_time(double time, ::builtin_interfaces::msg::dds_::Time_* stamp);
void set(const msg::Vector3& v, geometry::Vector3_* ros);
void set(const Vector3d& v, geometry::Vector3_* ros);
void set(const Vector3d& v, geometry::Point_* ros);
void set(const Vector3d& v, geometry::Point32_* ros);
void set(const Transform& X, geometry::Transform_* ros);

void set(const std::vector<NamedTransform>& frames, double time, ::tf2_msgs::msg::dds_::TFMessage_* ros);

// Names of joints, and frame_id, stay as they are.
void set(const msg::SensorData& sensors, sensor::JointState_* ros);
void set(const msg::ImuSample& sample, double time, sensor::Imu_* ros);
void set(const msg::WrenchSample& sample, double time, geometry::WrenchStamped_* ros);

}  // namespace hrp::ros
