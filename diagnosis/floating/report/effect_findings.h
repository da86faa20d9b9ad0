// SPDX-License-Identifier: BSD-3-Clause
// Findings of the search.
#pragma once

#include "diagnosis/floating/report/report_state.h"

namespace hrp::diagnosis::floating {

// Adds a finding for each listed effect that was found.
void add_effect_findings(ReportState* state);

}  // namespace hrp::diagnosis::floating
