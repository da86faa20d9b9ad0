// SPDX-License-Identifier: BSD-3-Clause
// What all findings together amount to.
#pragma once

#include "diagnosis/floating/report/report_state.h"

namespace hrp::diagnosis::floating {

// Makes findings ambiguous where the model leaves most of the mismatch, or where physics outside the table is at work:
// another cause may be behind both. Does not doubt a finding that explains its own equation, nor friction and rotors,
// which have shapes of their own.
void doubt_findings(ReportState* state);

Verdict find_verdict(const ReportState& state);

// A sentence for a report without findings: what was compared.
std::string make_summary(const ReportState& state);

}  // namespace hrp::diagnosis::floating
