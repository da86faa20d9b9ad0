// SPDX-License-Identifier: BSD-3-Clause
// What is predicted and compared: a robot's recordings, and what a hypothesis leaves of them.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/parallel_for.h"
#include "diagnosis/simulation/rollout.h"

namespace hrp::diagnosis {

// The paths of all joints along every recording under one hypothesis (empty for recordings nobody asked for).
using Paths = std::vector<RobotPath>;

// By recording; may be empty.
using Starts = std::vector<StartState>;

// What finer steps would add to simulated readings, by recording, laid out as the readings; may be empty, or elements
// be.
using StepErrors = std::vector<std::vector<double>>;

// What a prediction simulates: the whole robot; or, `along` its recorded paths, joint by joint; with `paths` those,
// else paths made anew from the hypothesis; of one `joint` only, or of all (-1).
struct View {
  bool along = false;
  const Paths* paths = nullptr;
  int joint = -1;
};

struct Subtree;

// What a search may cost: about two minutes of two cores (docs/diagnosis.md).
constexpr double kUsualWork = 5e8;

// Everything a fit reads; constant.
struct Problem {
  const Experiment* experiment = nullptr;
  std::vector<SmoothRecording> smooth;  // by recording
  std::vector<double> weights;          // 1 / sigma by joint * 3 + quantity
  std::vector<std::vector<float>> trust;  // factors of the weights by recording, laid out as readings; see trust.h
  RolloutOptions options;
  int jobs = 1;
  double most_work = kUsualWork;     // after which a search goes no further
  std::vector<int> train, validate;  // indices of recordings
  Starts starts;                     // of simulations of the whole robot; see start_state.h
  StepErrors step_errors;            // added to what those simulations read; see step_error.h
  Paths nominal_paths;               // of the nominal model: slopes for all others; see prepare_paths
  View view;                         // what residuals are of
  std::vector<Subtree> subtrees;           // of a robot that has more than one: simulated one by one; see subtrees.h
};

// Joints of a robot on a standing base that no other joints move or are moved by: a robot of its own.
struct Subtree {
  std::vector<int> joints;  // of the whole robot
  std::shared_ptr<const Experiment> experiment;
  Problem problem;
};

Problem make_problem(const Experiment& experiment, int jobs);
// Recordings that predictions are judged on: those that nothing is fitted to; where there is none, those of training.
const std::vector<int>& get_judged(const Problem& problem);
// 1 / sigma of a reading.
double get_weight(const Problem& problem, size_t recording, size_t sample, size_t channel);

// Fills problem->nominal_paths.
void prepare_paths(Problem* problem);
// Paths of all joints under a hypothesis; needs nominal paths. Joints with elastic transmissions are simulated to
// learn how their links move.
Paths make_paths(const Problem& problem, const Hypothesis& hypothesis);

// Sums of squares of whitened residuals (recorded - predicted) / sigma and their numbers.
struct Score {
  double chi2 = 0.0;
  double count = 0.0;
  std::vector<double> signal_chi2, signal_count;  // by joint * 3 + quantity
  bool ok = true;                                 // every rollout stayed finite
  double rms() const;
  double rms(size_t signal) const;  // of one signal; 0 where it was not recorded
  double worst() const;             // the largest of them
  void add(const Score& other);
};

// Whitened residuals of one recording under a hypothesis, [sample][joint * 3 + quantity], or [sample][quantity] where
// the view is of one joint; 0 where nothing was recorded.
bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording,
                    std::vector<double>* residuals);
// The same with other options and start than the problem's; of the samples before `until` only, where that is not 0.
bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording, const RolloutOptions& options,
                    const StartState* start, std::vector<double>* residuals);
// Of several recordings; their residuals go to `all`, by recording of the list, if it is given.
Score calc_score(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings,
                 std::vector<std::vector<double>>* all = nullptr);

}  // namespace hrp::diagnosis
