// SPDX-License-Identifier: BSD-3-Clause
// One of two feet's sensors of vertical force that is late. While the load moves from one foot to the other, a late
// sensor still reads the load that has gone, so that the sum of both is off by the delay times the rate.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"

namespace hrp::diagnosis::floating {

struct LateFoot {
  int sensor = -1, other = -1;  // -1: none is late
  double delay = 0, std = 0;    // [s] against the other one
};

// From the equation of the weight. What both feet share, a delay of both or a weight, is fitted beside it.
LateFoot find_late_foot(const LeggedLog& log, const std::vector<ChannelRows>& channels, const ColumnLayout& layout);

Finding make_late_finding(const LeggedLog& log, const LateFoot& late);

}  // namespace hrp::diagnosis::floating
