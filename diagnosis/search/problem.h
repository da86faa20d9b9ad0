// SPDX-License-Identifier: BSD-3-Clause
// The recordings of a robot, how they are predicted, and the residuals of a hypothesis.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/parallel_for.h"
#include "diagnosis/simulation/rollout.h"

namespace hrp::diagnosis {

// Paths of all joints along every recording under one hypothesis; empty for recordings that are not needed.
using Paths = std::vector<RobotPath>;

// Start states by recording; may be empty.
using Starts = std::vector<StartState>;

// Change of simulated readings by finer steps, by recording, in the order of the readings. It or its elements may be
// empty.
using StepErrors = std::vector<std::vector<double>>;

// What a prediction simulates. By default the whole robot; with `along`, each joint along recorded paths: `paths`, or
// new ones from the hypothesis if null. `joint`: only this joint; -1: all.
struct View {
  bool along = false;
  const Paths* paths = nullptr;
  int joint = -1;
};

struct Subtree;

// Limit of work of a search: about two minutes on two cores (docs/diagnosis.md).
constexpr double kUsualWork = 5e8;

// All inputs of a fit; constant.
struct Problem {
  const Experiment* experiment = nullptr;
  std::vector<SmoothRecording> smooth;    // by recording
  std::vector<double> weights;            // 1 / sigma by joint * 3 + quantity
  std::vector<std::vector<float>> trust;  // factors of the weights by recording, in the order of the readings (trust.h)
  RolloutOptions options;
  int jobs = 1;
  double most_work = kUsualWork;     // limit of work of a search
  std::vector<int> train, validate;  // indices of recordings
  Starts starts;                     // for simulations of the whole robot (start_state.h)
  StepErrors step_errors;            // added to the readings of these simulations (step_error.h)
  Paths nominal_paths;               // of the nominal model; their slopes serve all others (prepare_paths)
  View view;                         // what residuals are computed for
  std::vector<Subtree> subtrees;     // if there are several; each is simulated alone (subtrees.h)
};

// Joints on a fixed base that are dynamically independent of all others: a robot of its own.
struct Subtree {
  std::vector<int> joints;  // indices in the whole robot
  std::shared_ptr<const Experiment> experiment;
  Problem problem;
};

// Smooths the recordings and collects the inputs of a fit. The experiment must outlive the problem.
Problem make_problem(const Experiment& experiment, int jobs);
// Held-out recordings, on which predictions are judged; the training ones if none is held out.
const std::vector<int>& get_judged(const Problem& problem);
// 1 / sigma of a reading, with its trust factor.
double get_weight(const Problem& problem, size_t recording, size_t sample, size_t channel);

// Fills problem->nominal_paths.
void prepare_paths(Problem* problem);
// Paths of all joints under a hypothesis; requires nominal paths. Joints with elastic transmissions are simulated to
// obtain the motion of their links.
Paths make_paths(const Problem& problem, const Hypothesis& hypothesis);

// Sums of squared whitened residuals (recorded - predicted) / sigma, and their numbers.
struct Score {
  double chi2 = 0.0;
  double count = 0.0;
  std::vector<double> signal_chi2, signal_count;  // by joint * 3 + quantity
  bool ok = true;                                 // every rollout stayed finite
  double rms() const;
  double rms(size_t signal) const;  // of one signal; 0 if not recorded, 1e300 if no rollout succeeded
  double worst() const;             // largest rms of one signal
  void add(const Score& other);
};

// Whitened residuals of one recording, [sample][joint * 3 + quantity], or [sample][quantity] for a view of one joint; 0
// where nothing was recorded. Returns false if a rollout fails.
bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording,
                    std::vector<double>* residuals);
// The same with other options and another start state. With options.until > 0, only samples before that time.
bool calc_residuals(const Problem& problem, const Hypothesis& hypothesis, int recording, const RolloutOptions& options,
                    const StartState* start, std::vector<double>* residuals);
// Score of several recordings. `all`, if given, receives their residuals in the order of the list.
Score calc_score(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings,
                 std::vector<std::vector<double>>* all = nullptr);

}  // namespace hrp::diagnosis
