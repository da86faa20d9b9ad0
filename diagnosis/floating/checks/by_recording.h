// SPDX-License-Identifier: BSD-3-Clause
// What each recording says of weight, accelerometers, gyroscopes and soles, as figures to compare: a sensor that
// changed, or a push, is in one of them alone.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/floating/fit/row_table.h"

namespace hrp::diagnosis::floating {

// A sentence for each recording that says anything. `raw_counts`: forces are in an unknown unit.
std::vector<std::string> describe_recordings(const LeggedLog& log, const std::vector<ChannelRows>& channels,
                                             bool raw_counts);

}  // namespace hrp::diagnosis::floating
