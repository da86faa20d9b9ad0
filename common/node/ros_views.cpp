// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/ros_views.h"

#include <cmath>

#include "common/messages/topics.h"

namespace hrp {
namespace {

void set(const msg::Vector3& v, geometry_msgs::msg::dds_::Vector3_* ros) {
  ros->x(v.x());
  ros->y(v.y());
  ros->z(v.z());
}

void set_stamp(double time, std_msgs::msg::dds_::Header_* header) {
  const long long nanoseconds = std::llround(time * 1e9);
  header->stamp().sec(static_cast<int32_t>(nanoseconds / 1000000000));
  header->stamp().nanosec(static_cast<uint32_t>(nanoseconds % 1000000000));
}

TopicSpec make_named(TopicSpec topic, const std::string& name) {
  topic.name += "/" + name;
  return topic;
}

}  // namespace

RosViews::RosViews(Bus& bus, const TreeSpec& tree, const SensorsSpec& sensors) {
  joint_states_.resize(1);
  joint_states_[0].publisher = {bus, topics::kRosJointStates};
  for (int i = 0; i < tree.num_joints(); ++i) joint_states_[0].message.name().push_back(tree.joint(i).name);
  imus_.resize(sensors.imus.size());
  for (size_t i = 0; i < imus_.size(); ++i) {
    imus_[i].publisher = {bus, make_named(topics::kRosImu, sensors.imus[i].name)};
    imus_[i].message.header().frame_id(sensors.imus[i].link);
  }
  wrenches_.resize(sensors.wrenches.size());
  for (size_t i = 0; i < wrenches_.size(); ++i) {
    wrenches_[i].publisher = {bus, make_named(topics::kRosWrench, sensors.wrenches[i].name)};
    wrenches_[i].message.header().frame_id(sensors.wrenches[i].link);
  }
}

void RosViews::update_readers() {
  for (auto& view : joint_states_) view.wanted = view.publisher.has_readers();
  for (auto& view : imus_) view.wanted = view.publisher.has_readers();
  for (auto& view : wrenches_) view.wanted = view.publisher.has_readers();
}

void RosViews::publish(const msg::SensorData& sensors) {
  for (auto& view : joint_states_) {
    if (!view.wanted) continue;
    set_stamp(sensors.header().time(), &view.message.header());
    view.message.position() = sensors.positions();
    view.message.velocity() = sensors.velocities();
    view.message.effort() = sensors.efforts();
    view.publisher.publish(view.message);
  }
  for (size_t i = 0; i < imus_.size(); ++i) {
    auto& view = imus_[i];
    if (!view.wanted) continue;
    const msg::ImuSample& sample = sensors.imus()[i];
    set_stamp(sensors.header().time(), &view.message.header());
    view.message.orientation().x(sample.orientation().x());
    view.message.orientation().y(sample.orientation().y());
    view.message.orientation().z(sample.orientation().z());
    view.message.orientation().w(sample.orientation().w());
    set(sample.angular_velocity(), &view.message.angular_velocity());
    set(sample.linear_acceleration(), &view.message.linear_acceleration());
    view.publisher.publish(view.message);
  }
  for (size_t i = 0; i < wrenches_.size(); ++i) {
    auto& view = wrenches_[i];
    if (!view.wanted) continue;
    set_stamp(sensors.header().time(), &view.message.header());
    set(sensors.wrenches()[i].force(), &view.message.wrench().force());
    set(sensors.wrenches()[i].torque(), &view.message.wrench().torque());
    view.publisher.publish(view.message);
  }
}

}  // namespace hrp
