// SPDX-License-Identifier: BSD-3-Clause
// Output-error fits: adapts the parameters of a hypothesis so that simulated readings match recorded ones.
#pragma once

#include <vector>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

constexpr size_t kIndependent = 40;  // stretches of a recording whose residuals count as independent

// Result of a fit; `ok` is false if no rollout of the start values stays finite.
struct FitResult {
  Hypothesis hypothesis;
  std::vector<std::vector<double>> std;  // by effect, by parameter; 0 where fixed
  std::vector<double> distance;          // by effect: from zero, all parameters together, in standard deviations
  Score train;
  bool ok = false;
  int iterations = 0;
};

struct FitOptions {
  int max_iterations = 12;
  double tolerance = 1e-4;  // relative to chi2
  bool intervals = false;
  double abandon_above = 0.0;  // chi2; a fit above it ends after the third step; 0: never
  std::vector<char> frozen;    // by effect: parameters stay fixed; may be shorter than the hypothesis
};

// A hypothesis with one parameter changed by `delta`, for finite differences. Scanned and frozen parameters have none.
struct Move {
  Hypothesis hypothesis;
  double delta;
  size_t effect = 0;  // index of the effect of this parameter
};
std::vector<Move> list_moves(const Hypothesis& hypothesis, const std::vector<char>& frozen = {});

// Levenberg-Marquardt fit to the given recordings.
FitResult fit(const Problem& problem, const Hypothesis& start, const std::vector<int>& recordings,
              const FitOptions& options);

}  // namespace hrp::diagnosis
