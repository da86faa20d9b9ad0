// SPDX-License-Identifier: BSD-3-Clause
// Zeros of a leg's encoders, which have its sole askew by the same angle in every recording.
#pragma once

#include "diagnosis/floating/checks/checks.h"

namespace hrp::diagnosis::floating {

// An ambiguous finding for each leg whose sole is askew alone: the joints whose zero would do that. An attitude that is
// off, or a slope, tilts the soles of all legs.
void check_leg_zeros(const LeggedLog& log, const std::vector<ChannelRows>& channels, const ColumnLayout& layout,
                     CheckResult* out);

}  // namespace hrp::diagnosis::floating
