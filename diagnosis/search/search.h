// SPDX-License-Identifier: BSD-3-Clause
// From recordings to a verdict: which effects, if any, explain the mismatch.
#pragma once

#include <functional>

#include "diagnosis/search/screen.h"

namespace hrp::diagnosis {

// A hypothesis that was fitted on the training recordings and judged on the others.
struct Trial {
  Hypothesis hypothesis;                  // without the timing of the drive's loop
  Hypothesis timing;                      // of the drives' loops, a limb each; empty: they take no time
  std::vector<std::vector<double>> std;   // by effect, by parameter
  std::vector<double> distance;           // by effect, see FitResult
  Starts starts;                          // of all recordings, under this hypothesis
  StepErrors step_errors;
  Score train, validate;
  double rms = 1e300;                     // on the recordings it was not fitted to
  double worst = 1e300;                   // largest root mean square of one signal there
  double probability = 0.0;
  bool refined = false;                   // fitted to the end, with timing
  std::vector<Trial> limbs;               // of a robot of several: starts and step errors
  Hypothesis full() const;                // with the timing
};

struct Outcome {
  Trial nominal;                          // nothing added
  Trial chosen;                           // best model found, named or not
  bool mismatch = false, explained = false, partly = false;
  bool modelled = false;                  // the chosen model predicts better, though nothing in it is certain
  std::vector<Trial> rivals;              // best first, the chosen one too
  std::vector<Hypothesis> twins;          // as good as the chosen one: the data cannot tell
  // Of a partial explanation, by effect of the chosen model (empty: all are findings): by what factor the held-out
  // error of its joint grows without it (infinite: its limb is explained), 0 where it only helps to predict, and why it
  // is not certain then.
  std::vector<double> worth;
  std::vector<std::string> doubts;
};

using Progress = std::function<void(const std::string&)>;

Outcome search(const Problem& problem, const Progress& progress);

}  // namespace hrp::diagnosis
