// SPDX-License-Identifier: BSD-3-Clause
// Names, types and retention of every topic. idl/README.md has the same table with writers, readers and rates.
#pragma once

#include <string>
#include <vector>

#include "common/bus/bus.h"

namespace hrp::topics {

inline const TopicSpec kRobotDescription{"hrp/robot_description", "hrp::msg::RobotDescription", Retention::kLatest, 1};
inline const TopicSpec kModelRefused{"hrp/model_refused", "hrp::msg::ModelRefused", Retention::kLatest, 1};
inline const TopicSpec kRobotState{"hrp/robot_state", "hrp::msg::RobotState"};
inline const TopicSpec kSensorData{"hrp/sensor_data", "hrp::msg::SensorData"};
inline const TopicSpec kContactSet{"hrp/contact_set", "hrp::msg::ContactSet"};
inline const TopicSpec kContactForces{"hrp/contact_forces", "hrp::msg::ContactForces", Retention::kStream, 1024,
                                      /*gathered=*/true};
inline const TopicSpec kEvents{"hrp/events", "hrp::msg::RobotEvent"};
inline const TopicSpec kJointCommands{"hrp/joint_commands", "hrp::msg::JointCommands"};
inline const TopicSpec kServerStatus{"hrp/server_status", "hrp::msg::ServerStatus", Retention::kLatest, 1};
inline const TopicSpec kStepGrant{"hrp/step_grant", "hrp::msg::StepGrant", Retention::kLatest, 1};
inline const TopicSpec kRunControl{"hrp/run_control", "hrp::msg::RunControl"};
inline const TopicSpec kRunStatus{"hrp/run_status", "hrp::msg::RunStatus", Retention::kLatest, 1};
// For eyes only, see common/node/view_writer.h: as few as possible are kept.
inline const TopicSpec kView{"hrp/view", "hrp::msg::View", Retention::kStream, 4};
// Samples of other topics, for the logger: see common/node/log_samples.h.
inline const TopicSpec kLogSamples{"hrp/log_samples", "hrp::msg::View"};
// What cameras and lidars took of one state; large.
inline const TopicSpec kPictures{"hrp/pictures", "hrp::msg::Pictures", Retention::kStream, 4};
inline const TopicSpec kRosJointStates{"rt/joint_states", "sensor_msgs::msg::dds_::JointState_"};
// rt/imu/<name> and rt/wrench/<name> are made from these.
inline const TopicSpec kRosImu{"rt/imu", "sensor_msgs::msg::dds_::Imu_"};
inline const TopicSpec kRosWrench{"rt/wrench", "geometry_msgs::msg::dds_::WrenchStamped_"};

// Of one robot where a scenario has several: "hrp/partner/sensor_data", "rt/partner/joint_states" for robot "partner",
// the plain name for "".
inline TopicSpec of_robot(TopicSpec topic, const std::string& robot) {
  if (!robot.empty()) topic.name.insert(topic.name.find('/') + 1, robot + "/");
  return topic;
}

// "rt/imu/chest" -> "/imu/chest", as tools of ROS 2 write it; "" of a topic that ROS 2 does not see.
inline std::string find_ros_topic(const std::string& topic) {
  return topic.rfind("rt/", 0) == 0 ? topic.substr(2) : "";
}

// "partner" of "hrp/partner/sensor_data"; "" of a topic of the first robot.
inline std::string find_robot(const std::string& topic) {
  const size_t first = topic.find('/'), last = topic.rfind('/');
  return first == last || topic.compare(0, first, "hrp") != 0 ? "" : topic.substr(first + 1, last - first - 1);
}

// Topics that each robot has of its own.
inline const TopicSpec* const kOfRobot[] = {&kRobotDescription, &kSensorData, &kJointCommands, &kEvents,
                                            &kRosJointStates};

// "rt/partner/imu/chest" -> "rt/imu/chest": the name that the first robot's topic would have. "" of a name without a
// robot.
inline std::string drop_robot(const std::string& topic) {
  const size_t first = topic.find('/'), second = first == std::string::npos ? first : topic.find('/', first + 1);
  return second == std::string::npos ? "" : topic.substr(0, first) + topic.substr(second);
}

// The topic of the IMU or force sensor of this name, or nullptr.
inline const TopicSpec* find_sensor_topic(const std::string& name) {
  for (const TopicSpec* topic : {&kRosImu, &kRosWrench}) {
    if (name.rfind(topic->name + "/", 0) == 0) return topic;
  }
  return nullptr;
}

// The topic of a name as we publish it: nullptr for names that are not ours. For the ROS views with a name of their own
// (rt/imu/<name>, rt/wrench/<name>), and topics of other robots (hrp/<robot>/sensor_data), it is the one that they are
// made from.
inline const TopicSpec* find_known_topic(const std::string& name) {
  static const TopicSpec* const kAll[] = {&kRobotDescription, &kModelRefused,  &kRobotState,    &kSensorData,
                                          &kContactSet,       &kContactForces, &kJointCommands, &kServerStatus,
                                          &kStepGrant,        &kRunControl,    &kRunStatus,     &kView,
                                          &kEvents,           &kPictures,      &kLogSamples,    &kRosJointStates};
  for (const TopicSpec* topic : kAll) {
    if (topic->name == name) return topic;
  }
  if (const TopicSpec* sensor = find_sensor_topic(name)) return sensor;
  const std::string plain = drop_robot(name);
  for (const TopicSpec* topic : kOfRobot) {
    if (topic->name == plain) return topic;
  }
  return find_sensor_topic(plain);
}

// Topics that people mean by `name`: the one of this name, else that of the run or of its first robot (sensor_data,
// imu/chest), else those that end with it (partner/sensor_data, chest). A slash in front is what other tools write, and
// changes nothing.
inline std::vector<std::string> find_meant_topics(const std::string& name, const std::vector<std::string>& names) {
  const std::string plain = !name.empty() && name[0] == '/' ? name.substr(1) : name;
  const std::string end = "/" + plain;
  std::vector<std::string> meant, of_first;
  for (const std::string& each : names) {
    if (each == plain) return {each};
    if (each == "hrp/" + plain || find_ros_topic(each) == end) of_first.push_back(each);
    if (each.size() > end.size() && each.compare(each.size() - end.size(), end.size(), end) == 0) meant.push_back(each);
  }
  return of_first.empty() ? meant : of_first;
}

}  // namespace hrp::topics
