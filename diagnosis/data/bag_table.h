// SPDX-License-Identifier: BSD-3-Clause
// ROS bags as tables of the tool (docs/rosbag.md).
//
// Every topic has its own samples and its own clock (topic_clock.h). The rows of a table are the samples of the fastest
// topic of joint states. Readings of other topics are interpolated linearly, commands are held. Nothing is interpolated
// across a gap; a gap divides a bag into several tables.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/bag_topics.h"
#include "diagnosis/data/csv.h"

namespace hrp::diagnosis {

struct BagTable {
  Table table;
  std::string part;  // "" of a bag without gaps, else " (12.3 to 45.6 s)"
};

// Reads a bag. Throws InputError that names bag, topic and field. `notes` receives the topics used, rates, clocks,
// gaps, and joints that the model does not have.
std::vector<BagTable> read_bag(const std::string& path, const TopicMap& map, const BagRobot& robot,
                               const std::string& experiment, std::vector<std::string>* notes);

}  // namespace hrp::diagnosis
