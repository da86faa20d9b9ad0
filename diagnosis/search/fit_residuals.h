// SPDX-License-Identifier: BSD-3-Clause
// The fit of fit.h for other residuals than those of a problem's simulated readings.
#pragma once

#include <functional>

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// Whitened residuals of one recording; false if the prediction fails. Their number must not depend on the hypothesis.
using CalcResiduals = std::function<bool(const Hypothesis& hypothesis, int recording, std::vector<double>* residuals)>;

// Sum of squares and number of residuals that are not 0. The score has no values by signal.
Score calc_score(const CalcResiduals& calc, int jobs, const Hypothesis& hypothesis, const std::vector<int>& recordings,
                 std::vector<std::vector<double>>* all = nullptr);

FitResult fit(const CalcResiduals& calc, int jobs, const Hypothesis& start, const std::vector<int>& recordings,
              const FitOptions& options);

}  // namespace hrp::diagnosis
