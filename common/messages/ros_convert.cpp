// SPDX-License-Identifier: BSD-3-Clause
#include "common/messages/ros_convert.h"

#include <cmath>

namespace hrp::ros {

void set_time(double time, ::builtin_interfaces::msg::dds_::Time_* stamp) {
  const long long nanoseconds = std::llround(time * 1e9);
  stamp->sec(static_cast<int32_t>(nanoseconds / 1000000000));
  stamp->nanosec(static_cast<uint32_t>(nanoseconds % 1000000000));
}

void set(const msg::Vector3& v, geometry::Vector3_* ros) {
  ros->x(v.x());
  ros->y(v.y());
  ros->z(v.z());
}

void set(const Vector3d& v, geometry::Vector3_* ros) {
  ros->x(v.x());
  ros->y(v.y());
  ros->z(v.z());
}

void set(const Vector3d& v, geometry::Point_* ros) {
  ros->x(v.x());
  ros->y(v.y());
  ros->z(v.z());
}

void set(const Vector3d& v, geometry::Point32_* ros) {
  ros->x(static_cast<float>(v.x()));
  ros->y(static_cast<float>(v.y()));
  ros->z(static_cast<float>(v.z()));
}

void set(const Transform& X, geometry::Transform_* ros) {
  const Eigen::Quaterniond q(X.R);
  set(X.p, &ros->translation());
  ros->rotation().x(q.x());
  ros->rotation().y(q.y());
  ros->rotation().z(q.z());
  ros->rotation().w(q.w());
}

void set(const std::vector<NamedTransform>& frames, double time, ::tf2_msgs::msg::dds_::TFMessage_* ros) {
  ros->transforms().resize(frames.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    auto& at = ros->transforms()[i];
    set_time(time, &at.header().stamp());
    at.header().frame_id(frames[i].parent);
    at.child_frame_id(frames[i].child);
    set(frames[i].X_PC, &at.transform());
  }
}

void set(const msg::SensorData& sensors, sensor::JointState_* ros) {
  set_time(sensors.header().time(), &ros->header().stamp());
  ros->position() = sensors.positions();
  ros->velocity() = sensors.velocities();
  ros->effort() = sensors.efforts();
}

void set(const msg::ImuSample& sample, double time, sensor::Imu_* ros) {
  set_time(time, &ros->header().stamp());
  ros->orientation().x(sample.orientation().x());
  ros->orientation().y(sample.orientation().y());
  ros->orientation().z(sample.orientation().z());
  ros->orientation().w(sample.orientation().w());
  set(sample.angular_velocity(), &ros->angular_velocity());
  set(sample.linear_acceleration(), &ros->linear_acceleration());
}

void set(const msg::WrenchSample& sample, double time, geometry::WrenchStamped_* ros) {
  set_time(time, &ros->header().stamp());
  set(sample.force(), &ros->wrench().force());
  set(sample.torque(), &ros->wrench().torque());
}

}  // namespace hrp::ros
