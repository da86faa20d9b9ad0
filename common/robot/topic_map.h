// SPDX-License-Identifier: BSD-3-Clause
// The section `topics` of an experiment: which topics of a ROS bag hold which signals (docs/rosbag.md).
#pragma once

#include <map>
#include <string>
#include <vector>

namespace hrp {

// Which clock a topic's samples are placed on.
enum class StampSource { kHeader, kReceive };

// One topic behind a signal.
struct SignalTopic {
  std::string signal;  // "joint_states", "joint_commands", "joint_states_link", "imu/pelvis", "wrench/l_foot", "base"
  std::string topic;   // "/joint_states"
  std::vector<std::string> joints;            // names by position, for messages without names
  std::map<std::string, std::string> rename;  // name in the bag -> name in the model
  std::map<std::string, std::string> fields;  // "position" -> "motor_state[].q"; for types that the tool does not know
  std::string quantity = "position";          // what a plain list of numbers is
  StampSource stamps = StampSource::kHeader;
  int line = 0, column = 0;  // in the experiment
};

struct TopicMap {
  std::vector<SignalTopic> topics;  // empty: by name and type
};

// From the text of an experiment file. Throws InputError with file, line, column.
TopicMap parse_topic_map(const std::string& text, const std::string& path);

}  // namespace hrp
