// SPDX-License-Identifier: BSD-3-Clause
// What is left of a robot and what is right, by names that differ in left and right alone.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis::floating {

using SidePairs = std::vector<std::pair<size_t, size_t>>;  // left, right

// What the right one may be called: "left" or one "l" of the left one's name otherwise.
std::vector<std::string> list_right_names(const std::string& left);

std::set<int> list_leg_joints(const LeggedLog& log);  // above feet
SidePairs list_leg_pairs(const LeggedLog& log);       // of them
SidePairs list_sensor_pairs(const LeggedLog& log);    // force sensors of feet with the same axes, by index in the log

// The log with each joint's positions, or each sensor's readings, for those of the other side.
LeggedLog exchange_legs(LeggedLog log, const SidePairs& joints);
LeggedLog exchange_feet(LeggedLog log, const SidePairs& sensors);

}  // namespace hrp::diagnosis::floating
