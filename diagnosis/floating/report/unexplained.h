// SPDX-License-Identifier: BSD-3-Clause
// What the model leaves: equations that keep a mismatch, and physics that no scenario can hold.
#pragma once

#include "diagnosis/floating/report/report_state.h"

namespace hrp::diagnosis::floating {

// Adds free laws and equations. Equations where effects of no one size were dropped are listed only without findings:
// the verdict stands on them then.
void add_unexplained(ReportState* state);

// Equations that a dropped effect helped, and that nothing has explained since. Soles lie a little askew all the time.
std::vector<size_t> list_unsteady(const ReportState& state);

}  // namespace hrp::diagnosis::floating
