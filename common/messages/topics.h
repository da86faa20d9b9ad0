// SPDX-License-Identifier: BSD-3-Clause
// Names, types and retention of every topic. idl/README.md has the same table with writers, readers and rates.
#pragma once

#include "common/bus/bus.h"

namespace hrp::topics {

inline const TopicSpec kRobotDescription{"hrp/robot_description", "hrp::msg::RobotDescription", Retention::kLatest, 1};
inline const TopicSpec kModelRefused{"hrp/model_refused", "hrp::msg::ModelRefused", Retention::kLatest, 1};
inline const TopicSpec kRobotState{"hrp/robot_state", "hrp::msg::RobotState"};
inline const TopicSpec kSensorData{"hrp/sensor_data", "hrp::msg::SensorData"};
inline const TopicSpec kContactSet{"hrp/contact_set", "hrp::msg::ContactSet"};
inline const TopicSpec kContactForces{"hrp/contact_forces", "hrp::msg::ContactForces"};
inline const TopicSpec kJointCommands{"hrp/joint_commands", "hrp::msg::JointCommands"};
inline const TopicSpec kServerStatus{"hrp/server_status", "hrp::msg::ServerStatus", Retention::kLatest, 1};
inline const TopicSpec kStepGrant{"hrp/step_grant", "hrp::msg::StepGrant", Retention::kLatest, 1};
inline const TopicSpec kRunControl{"hrp/run_control", "hrp::msg::RunControl"};
inline const TopicSpec kRunStatus{"hrp/run_status", "hrp::msg::RunStatus", Retention::kLatest, 1};
inline const TopicSpec kRosJointStates{"rt/joint_states", "sensor_msgs::msg::dds_::JointState_"};
// rt/imu/<name> and rt/wrench/<name> are made from these.
inline const TopicSpec kRosImu{"rt/imu", "sensor_msgs::msg::dds_::Imu_"};
inline const TopicSpec kRosWrench{"rt/wrench", "geometry_msgs::msg::dds_::WrenchStamped_"};

}  // namespace hrp::topics
