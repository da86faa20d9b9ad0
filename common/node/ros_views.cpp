// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/ros_views.h"

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

RosViews::RosViews(Bus& bus, const RobotDescription& robot, const SensorsSpec& sensors)
    : tf_static_(bus, topics::kRosTfStatic),
      robot_description_(bus, topics::kRosRobotDescription),
      tree_(std::make_unique<FrameTree>(robot.tree)) {
  std_msgs::msg::dds_::String_ urdf;
  urdf.data(robot.urdf);
  robot_description_.publish(urdf);
  tf2_msgs::msg::dds_::TFMessage_ fixed;
  ros::set(tree_->make_fixed(), 0.0, &fixed);
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

void RosViews::publish_frames(double time, const State& state) {
  for (auto& view : clock_) {
    if (!view.wanted) continue;
    ros::set_time(time, &view.message.clock());
    view.publisher.publish(view.message);
  }
  for (auto& view : tf_) {
    if (!view.wanted) continue;
    tree_->update_moving(state, &moving_);
    ros::set(moving_, time, &view.message);
    view.publisher.publish(view.message);
  }
}

void RosViews::publish(const msg::SensorData& sensors, const State& state) {
  const double time = sensors.header().time();
  publish_frames(time, state);
  for (auto& view : joint_states_) {
    if (!view.wanted) continue;
    ros::set(sensors, &view.message);
    view.publisher.publish(view.message);
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
