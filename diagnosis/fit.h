// SPDX-License-Identifier: BSD-3-Clause
// Output-error fits: parameters of a hypothesis so that the simulated readings meet the recorded ones.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/rollout.h"

namespace hrp::diagnosis {

// Everything a fit reads; constant.
struct Problem {
  const Experiment* experiment = nullptr;
  std::vector<SmoothRecording> smooth;    // by recording
  std::vector<double> weights;            // 1 / sigma by joint * 3 + quantity
  RolloutOptions options;
  int jobs = 1;
  std::vector<int> train, validate;       // indices of recordings
};

Problem make_problem(const Experiment& experiment, int jobs);

// Calls work(i) for i in [0, count) on up to `jobs` threads. Results must go to slots of their own.
void parallel_for(int jobs, int count, const std::function<void(int)>& work);

// Sums of squares of whitened residuals (recorded - predicted) / sigma and their numbers.
struct Score {
  double chi2 = 0.0;
  double count = 0.0;
  std::vector<double> signal_chi2, signal_count;   // by joint * 3 + quantity
  bool ok = true;                                  // every rollout stayed finite
  double rms() const;
  void add(const Score& other);
};

// Whitened residuals of one recording under a hypothesis, [sample][joint * 3 + quantity], 0 where nothing was recorded.
bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording, std::vector<double>* residuals);
Score calc_score(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings);

struct FitResult {
  Hypothesis hypothesis;
  std::vector<std::vector<double>> std;   // by effect, by parameter; 0 where fixed
  Score train;
  bool ok = false;
  int iterations = 0;
};

struct FitOptions {
  int max_iterations = 12;
  double tolerance = 1e-4;    // of chi2, relative
  bool intervals = false;
  double abandon_above = 0.0; // chi2 above which the third step is the last; 0: never
};

FitResult fit(const Problem& problem, const Hypothesis& start, const std::vector<int>& recordings, const FitOptions& options);

}  // namespace hrp::diagnosis
