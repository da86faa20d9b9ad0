// SPDX-License-Identifier: BSD-3-Clause
// Curves for people: maps of residuals over time, recorded against predicted, and the rivals
// (docs/diagnosis_series.md).
#pragma once

#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

// `after`: the model whose prediction is shown beside the nominal one.
Json make_series(const Problem& problem, const Outcome& outcome, const Trial& after);

}  // namespace hrp::diagnosis
