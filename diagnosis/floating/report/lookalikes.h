// SPDX-License-Identifier: BSD-3-Clause
// Effects that no recorded signal tells apart from a finding. The search finds most of them as rivals. The rules here
// add those that it cannot try: they have no column in these equations, or differ from the finding by a combination of
// effects.
#pragma once

#include "diagnosis/floating/report/report_state.h"

namespace hrp::diagnosis::floating {

// Adds alternatives to the finding of `found`; a finding with one is ambiguous.
void add_lookalikes(const ReportState& state, const FoundEffect& found, Finding* finding);

}  // namespace hrp::diagnosis::floating
