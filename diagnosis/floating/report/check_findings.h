// SPDX-License-Identifier: BSD-3-Clause
// Findings of the checks on whole recordings, where the search has not named the same already.
#pragma once

#include "diagnosis/floating/checks/checks.h"
#include "diagnosis/floating/report/report_state.h"

namespace hrp::diagnosis::floating {

// After the findings of the search. A mass goes into the model, too.
void add_check_findings(const CheckResult& checks, ReportState* state);

}  // namespace hrp::diagnosis::floating
