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

RosViews::RobotViews::RobotViews(Bus& bus, const Mover& robot, const FrameTree& tree)
    : description(bus, topics::of_robot(topics::kRosRobotDescription, robot.name)) {
  const SensorsSpec& sensors = robot.scenario.sensors;
  const TreeSpec& links = robot.robot.tree;
  std_msgs::msg::dds_::String_ urdf;
  urdf.data(robot.robot.urdf);
  description.publish(urdf);
  joint_states.publisher = {bus, topics::of_robot(topics::kRosJointStates, robot.name)};
  for (int i = 0; i < links.num_joints(); ++i) joint_states.message.name().push_back(links.joint(i).name);
  imus.resize(sensors.imus.size());
  for (size_t i = 0; i < imus.size(); ++i) {
    imus[i].publisher = {bus, make_named(topics::of_robot(topics::kRosImu, robot.name), sensors.imus[i].name)};
    imus[i].message.header().frame_id(tree.find_frame(sensors.imus[i].link));
  }
  wrenches.resize(sensors.wrenches.size());
  for (size_t i = 0; i < wrenches.size(); ++i) {
    wrenches[i].publisher = {bus,
                             make_named(topics::of_robot(topics::kRosWrench, robot.name), sensors.wrenches[i].name)};
    wrenches[i].message.header().frame_id(tree.find_frame(sensors.wrenches[i].link));
  }
}

void RosViews::RobotViews::update_readers() {
  joint_states.wanted = joint_states.publisher.has_readers();
  for (auto& view : imus) view.wanted = view.publisher.has_readers();
  for (auto& view : wrenches) view.wanted = view.publisher.has_readers();
}

void RosViews::RobotViews::publish_joint_states(const msg::SensorData& sensors) {
  if (!joint_states.wanted) return;
  ros::set(sensors, &joint_states.message);
  joint_states.publisher.publish(joint_states.message);
}

void RosViews::RobotViews::publish_sensors(const msg::SensorData& sensors) {
  const double time = sensors.header().time();
  for (size_t i = 0; i < imus.size(); ++i) {
    if (!imus[i].wanted) continue;
    ros::set(sensors.imus()[i], time, &imus[i].message);
    imus[i].publisher.publish(imus[i].message);
  }
  for (size_t i = 0; i < wrenches.size(); ++i) {
    if (!wrenches[i].wanted) continue;
    ros::set(sensors.wrenches()[i], time, &wrenches[i].message);
    wrenches[i].publisher.publish(wrenches[i].message);
  }
}

RosViews::RosViews(Bus& bus, const std::vector<Mover>& robots, double rate)
    : tf_static_(bus, topics::kRosTfStatic), trees_(make_frame_trees(robots)), rate_(rate) {
  for (size_t k = 0; k < robots.size(); ++k) robots_.emplace_back(bus, robots[k], trees_[k]);
  tf2_msgs::msg::dds_::TFMessage_ message;
  ros::set(make_fixed_frames(trees_, robots), 0.0, &message);
  tf_static_.publish(message);
  clock_.resize(1);
  clock_[0].publisher = {bus, topics::kRosClock};
  tf_.resize(1);
  tf_[0].publisher = {bus, topics::kRosTf};
}

void RosViews::update_readers() {
  for (auto& view : clock_) view.wanted = view.publisher.has_readers();
  for (auto& view : tf_) view.wanted = view.publisher.has_readers();
  for (RobotViews& robot : robots_) robot.update_readers();
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

void RosViews::publish_frames(double time, const std::vector<RobotSample>& samples) {
  for (auto& view : tf_) {
    if (!view.wanted) continue;
    all_moving_.clear();
    for (size_t k = 0; k < trees_.size(); ++k) {
      trees_[k].update_moving(*samples[k].state, &moving_);
      all_moving_.insert(all_moving_.end(), moving_.begin(), moving_.end());
    }
    ros::set(all_moving_, time, &view.message);
    view.publisher.publish(view.message);
  }
}

void RosViews::publish(const std::vector<RobotSample>& samples) {
  if (robots_.empty()) return;
  const double time = samples[0].sensors->header().time();
  publish_clock(time);
  if (is_due(time)) {
    publish_frames(time, samples);
    for (size_t k = 0; k < robots_.size(); ++k) robots_[k].publish_joint_states(*samples[k].sensors);
  }
  for (size_t k = 0; k < robots_.size(); ++k) robots_[k].publish_sensors(*samples[k].sensors);
}

}  // namespace hrp
