// SPDX-License-Identifier: BSD-3-Clause
// How exactly the values of an effect are known.
#pragma once

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// Standard errors of an effect's coefficients: the robust covariance, or the standard error of the mean over recordings
// where that is larger. They tell whether the effect may be none.
Eigen::VectorXd calc_scatter(const SearchState& state, const LeggedFit& fit, size_t effect);

// Deviations that a report states: the robust covariance, widened to what recordings differ by (random effects), and
// what the equations are exact to. `all`: of a fit to all rows.
Eigen::VectorXd calc_deviation(const SearchState& state, const LeggedFit& fit, size_t effect, bool all = false);

// Standard deviation of an effect's first coefficient over recordings, relative to the coefficient.
double calc_spread(const SearchState& state, const LeggedFit& fit, size_t effect);

}  // namespace hrp::diagnosis::floating
