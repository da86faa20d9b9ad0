// SPDX-License-Identifier: BSD-3-Clause
// What feet that are put down leave of the weight's equation: peaks and dips that a rigid foot on rigid ground, put
// down softly, has not.
#pragma once

#include "diagnosis/floating/checks/checks.h"

namespace hrp::diagnosis::floating {

void check_landings(const LeggedLog& log, const Contacts& contacts, const std::vector<ChannelRows>& channels,
                    CheckResult* out);

}  // namespace hrp::diagnosis::floating
