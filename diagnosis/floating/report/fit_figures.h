// SPDX-License-Identifier: BSD-3-Clause
// How well the nominal model and the found one fit, by signal and in all.
#pragma once

#include "diagnosis/floating/checks/checks.h"
#include "diagnosis/floating/report/report_state.h"

namespace hrp::diagnosis::floating {

// `units`: what the scales of raw counts leave of the weight.
void add_fit_figures(const UnitFit& units, ReportState* state);

}  // namespace hrp::diagnosis::floating
