// SPDX-License-Identifier: BSD-3-Clause
// Output-error fits: parameters of a hypothesis so that the simulated readings meet the recorded ones.
#pragma once

#include <vector>

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

constexpr size_t kIndependent = 40;  // of a recording: residuals are taken to be independent between them, not within

struct FitResult {
  Hypothesis hypothesis;
  std::vector<std::vector<double>> std;  // by effect, by parameter; 0 where fixed
  std::vector<double> distance;          // by effect: from all its parameters being 0, in standard deviations
  Score train;
  bool ok = false;
  int iterations = 0;
};

struct FitOptions {
  int max_iterations = 12;
  double tolerance = 1e-4;  // of chi2, relative
  bool intervals = false;
  double abandon_above = 0.0;  // chi2 above which the third step is the last; 0: never
  std::vector<char> frozen;    // by effect: parameters stay as they are; may be shorter
};

// A hypothesis with one of its parameters moved, for differences; parameters that are scanned or frozen stay.
struct Move {
  Hypothesis hypothesis;
  double delta;
  size_t effect = 0;  // whose parameter it is
};
std::vector<Move> list_moves(const Hypothesis& hypothesis, const std::vector<char>& frozen = {});

FitResult fit(const Problem& problem, const Hypothesis& start, const std::vector<int>& recordings,
              const FitOptions& options);

}  // namespace hrp::diagnosis
