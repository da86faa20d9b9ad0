// SPDX-License-Identifier: BSD-3-Clause
// When the recordings depart from the nominal model.
#pragma once

#include "diagnosis/floating/report/report_state.h"

namespace hrp::diagnosis::floating {

void add_mismatches(ReportState* state);

}  // namespace hrp::diagnosis::floating
