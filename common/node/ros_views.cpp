// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/ros_views.h"

#include <cmath>

#include "common/messages/ros_convert.h"
#include "common/messages/ros_topics.h"
#include "common/messages/topics.h"

namespace hrp {
namespace {

TopicSpec make_named(TopicSpec topic, const std::string& name) {
  topic.name += "/" + name;
  return topic;
}

}  // namespace

std::string find_ros_rate_fault(double rate) {
  constexpr double kFastest = 1e5;  // [1/s] steps are no shorter
  return rate >= 0.0 && rate <= kFastest ? "" : "not a rate from 0 to 100000 a second";
}

RosViews::RosViews(Bus& bus, const RobotDescription& robot, const SensorsSpec& sensors, double rate)
    : tf_static_(bus, topics::kRosTfStatic),
      robot_description_(bus, topics::kRosRobotDescription),
      tree_(std::make_unique<FrameTree>(robot.tree)),
      rate_(rate) {
  std_msgs::msg::dds_::String_ urdf;
  urdf.data(robot.urdf);
  robot_description_.publish(urdf);
  tf2_msgs::msg::dds_::TFMessage_ fixed;
  ros::set(tree_->make_fixed(sensors), 0.0, &fixed);
  tf_static_.publish(fixed);
  clock_.resize(1);
  clock_[0].publisher = {bus, topics::kRosClock};
  tf_.resize(1);
  tf_[0].publisher = {bus, topics::kRosTf};
  joint_states_.resize(1);
  joint_states_[0].publisher = {bus, topics::kRosJointStates};
  for (int i = 0; i < robot.tree.num_joints(); ++i) joint_states_[0].message.name().push_back(robot.tree.joint(i).name);
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
  for (auto& view : clock_) view.wanted = view.publisher.has_readers();
  for (auto& view : tf_) view.wanted = view.publisher.has_readers();
  for (auto& view : joint_states_) view.wanted = view.publisher.has_readers();
  for (auto& view : imus_) view.wanted = view.publisher.has_readers();
  for (auto& view : wrenches_) view.wanted = view.publisher.has_readers();
}

// Times are multiples of the step, rounded: far less than a microsecond off.
bool RosViews::is_due(double time) {
  if (rate_ <= 0.0) return true;
  constexpr double kRounding = 1e-6;  // [s]
  const double multiple = std::floor((time + kRounding) * rate_);
  if (multiple == last_multiple_) return false;
  last_multiple_ = multiple;
  return true;
}

void RosViews::publish_clock(double time) {
  for (auto& view : clock_) {
    if (!view.wanted) continue;
    ros::set_time(time, &view.message.clock());
    view.publisher.publish(view.message);
  }
}

void RosViews::publish_frames(double time, const State& state) {
  for (auto& view : tf_) {
    if (!view.wanted) continue;
    tree_->update_moving(state, &moving_);
    ros::set(moving_, time, &view.message);
    view.publisher.publish(view.message);
  }
}

void RosViews::publish_joint_states(const msg::SensorData& sensors) {
  for (auto& view : joint_states_) {
    if (!view.wanted) continue;
    ros::set(sensors, &view.message);
    view.publisher.publish(view.message);
  }
}

void RosViews::publish(const msg::SensorData& sensors, const State& state) {
  const double time = sensors.header().time();
  publish_clock(time);
  if (is_due(time)) {
    publish_frames(time, state);
    publish_joint_states(sensors);
  }
  for (size_t i = 0; i < imus_.size(); ++i) {
    if (!imus_[i].wanted) continue;
    ros::set(sensors.imus()[i], time, &imus_[i].message);
    imus_[i].publisher.publish(imus_[i].message);
  }
  for (size_t i = 0; i < wrenches_.size(); ++i) {
    if (!wrenches_[i].wanted) continue;
    ros::set(sensors.wrenches()[i], time, &wrenches_[i].message);
    wrenches_[i].publisher.publish(wrenches_[i].message);
  }
}

}  // namespace hrp
