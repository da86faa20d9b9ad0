// SPDX-License-Identifier: BSD-3-Clause
// Times at which something else than the feet bears the robot: it lies on its trunk, hangs, or somebody holds it.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"

namespace hrp::diagnosis::floating {

struct Rest {
  int recording = 0;
  double begin = 0, end = 0;  // [s]
  double share = 1;           // of what the feet bear otherwise, over what the motion asks for
};

// In any unit of force: what feet bear is compared with what they bear most of the time.
std::vector<Rest> find_rests(const std::vector<ChannelRows>& channels, const ColumnLayout& layout);

// Takes their rows out of all equations but those of IMUs alone and of servos.
void drop_rests(const std::vector<Rest>& rests, std::vector<ChannelRows>* channels);

std::string describe(const Rest& rest, const std::string& recording);

}  // namespace hrp::diagnosis::floating
