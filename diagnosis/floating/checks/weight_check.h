// SPDX-License-Identifier: BSD-3-Clause
// What the feet carry against what the model weighs, by whole recordings; and forces that are no newtons.
#pragma once

#include <vector>

#include "diagnosis/floating/checks/checks.h"

namespace hrp::diagnosis::floating {

// Adds what it finds to `out`.
void check_weight(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                  const ColumnLayout& layout, CheckResult* out);
// Whether forces are in an unknown unit: CheckResult::raw_counts.
bool has_raw_counts(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                    const ColumnLayout& layout);

// The equation along which the robot weighs; null: none.
const ChannelRows* find_weight_equation(const std::vector<ChannelRows>& channels);

}  // namespace hrp::diagnosis::floating
