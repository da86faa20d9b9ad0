// SPDX-License-Identifier: BSD-3-Clause
// What the feet carry against what the model weighs, by whole recordings; and forces that are no newtons.
#pragma once

#include "diagnosis/measurement/floating/checks.h"

namespace hrp::diagnosis::floating {

// Adds what it finds to `out`.
void check_weight(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                  const ColumnLayout& layout, CheckResult* out);

// What feet that are put down leave of the weight's equation: peaks and dips that a rigid foot on rigid ground, put down
// softly, has not. Null channel: nothing weighs.
void check_landings(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels, CheckResult* out);

}  // namespace hrp::diagnosis::floating
