// SPDX-License-Identifier: BSD-3-Clause
// Which topics of a bag hold which signals, and how their messages become columns.
#pragma once

#include <string>
#include <vector>

#include "common/log/ros_bag.h"
#include "common/log/ros_types.h"
#include "common/robot/topic_map.h"

namespace hrp::diagnosis {

// What of the robot and its sensors a bag is read for.
struct BagRobot {
  std::vector<std::string> joints, imus, wrenches;
  bool floating = false;
};

// A topic that is read: its type, and the paths of its values.
struct BoundTopic {
  SignalTopic spec;
  size_t index = 0;  // in the bag
  RosType type;
  bool by_joint = false;         // joint_states and the like: lists with one element a joint
  std::string names;             // path of the joints' names; empty: by position
  std::vector<std::string> paths;    // of values: by_joint lists, else single numbers
  std::vector<std::string> columns;  // by_joint "position", ..., else whole names of columns
};

// Topics as the experiment maps them; without a section `topics` by name and type, which is said in `notes`. Throws
// InputError naming bag, topic, field and what was expected.
std::vector<BoundTopic> bind_topics(const RosBag& bag, const TopicMap& map, const BagRobot& robot,
                                    const std::string& experiment, std::vector<std::string>* notes);

}  // namespace hrp::diagnosis
