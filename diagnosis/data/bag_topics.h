// SPDX-License-Identifier: BSD-3-Clause
// Assigns the topics of a bag to signals, and converts their messages to columns.
#pragma once

#include <string>
#include <vector>

#include "common/log/ros_bag.h"
#include "common/log/ros_types.h"
#include "common/robot/topic_map.h"

namespace hrp::diagnosis {

// The joints and sensors that are read from a bag.
struct BagRobot {
  std::vector<std::string> joints, imus, wrenches;
  bool floating = false;
};

// A topic to read: its type and the paths of its values.
struct BoundTopic {
  SignalTopic spec;
  size_t index = 0;  // in the bag
  RosType type;
  bool by_joint = false;             // joint_states and similar: lists with one element per joint
  std::string names;                 // path of the joints' names; empty: in stated order
  std::vector<std::string> paths;    // of values: by_joint lists, else single numbers
  std::vector<std::string> columns;  // by_joint "position", ..., else complete column names
};

// For messages: "/joint_states (sensor_msgs/msg/JointState), ...".
std::string list_topics(const RosBag& bag);

// Commands differ from states by the names of their topics only, as their messages have the same types.
bool is_command_name(const std::string& name);

// Topics as the experiment maps them. Without a section `topics`, they are chosen by name and type, which `notes` says.
// Throws InputError that names bag, topic, field and the expected value.
std::vector<BoundTopic> bind_topics(const RosBag& bag, const TopicMap& map, const BagRobot& robot,
                                    const std::string& experiment, std::vector<std::string>* notes);

}  // namespace hrp::diagnosis
