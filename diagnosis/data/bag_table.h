// SPDX-License-Identifier: BSD-3-Clause
// ROS bags as tables of the tool (docs/rosbag.md).
//
// Every topic keeps its own samples on its own clock (topic_clock.h). Rows stand at the samples of the fastest topic of
// joint states; readings of other topics are linear between their samples, commands are held, and nothing is carried
// across a gap: there a bag falls into several tables.
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

// Throws InputError naming bag, topic and field. `notes`: topics that were taken, rates, clocks, gaps, joints that the
// model does not have.
std::vector<BagTable> read_bag(const std::string& path, const TopicMap& map, const BagRobot& robot,
                               const std::string& experiment, std::vector<std::string>* notes);

}  // namespace hrp::diagnosis
