// SPDX-License-Identifier: BSD-3-Clause
// The equations of a recording in two halves, joined, without rows that tell nothing.
#pragma once

#include <vector>

#include "diagnosis/floating/checks/rests.h"
#include "diagnosis/floating/fit/row_table.h"
#include "diagnosis/floating/log/contacts.h"

namespace hrp::diagnosis::floating {

// Joins rows of even and odd samples, without gyroscopes over feet that turn.
std::vector<ChannelRows> join_halves(const RowTable& even, const RowTable& odd);

// Which equations are used. Forces in an unknown unit tell nothing of masses and torques; drives may be judged
// elsewhere.
struct Used {
  bool forces = true, drives = true;
  std::vector<Rest> rests;  // in which the feet do not bear the robot
};
void drop_unused(const Used& used, std::vector<ChannelRows>* channels);

}  // namespace hrp::diagnosis::floating
