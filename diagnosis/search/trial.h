// SPDX-License-Identifier: BSD-3-Clause
// Fitted hypotheses, and which of them is preferred.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// A hypothesis that was fitted on the training recordings and judged on the others.
struct Trial {
  Hypothesis hypothesis;                 // without the timing of the drive's loop
  Hypothesis timing;                     // of the drives' loops, by subtree; empty: they take no time
  std::vector<std::vector<double>> std;  // by effect, by parameter
  std::vector<double> distance;          // by effect, see FitResult
  Starts starts;                         // of all recordings, under this hypothesis
  StepErrors step_errors;
  Score train, validate;
  double rms = 1e300;    // on the recordings it was not fitted to
  double worst = 1e300;  // largest root mean square of one signal there
  double probability = 0.0;
  bool refined = false;      // fitted to the end, with timing
  std::vector<Trial> subtrees;  // of a robot of several: starts and step errors
  Hypothesis full() const;   // with the timing
};

// chi2 of all recordings.
double calc_cost(const Trial& trial);
size_t count_parameters(const Hypothesis& hypothesis);
// Standard deviations of one effect's parameters; 0 where the trial has none.
std::vector<double> get_std(const Trial& trial, size_t effect);

// What a hypothesis has to earn, in chi2: effects, parameters, and factors far from one. `readings`: of all recordings.
double calc_own_price(const Hypothesis& hypothesis, double readings);
// Odds against the preferred one of a hypothesis that is dearer by so much (chi2 over the best one's noise, and own
// prices) and has so many parameters more; and how much dearer it is where two are left and
// it has this probability.
double calc_odds(double dearer, double more_parameters);
double calc_dearer(double probability);
// Of hypotheses that are listed beside the preferred one.
constexpr double kListed = 0.1;

// Nothing is left but noise.
bool is_noise(const Trial& trial);
// What is left is so small a share of what the nominal model left that it may be the details of laws.
bool is_detail(const Trial& trial, const Trial& nominal);
// One of the two, and more than the nominal model.
bool is_explained(const Trial& trial, const Trial& nominal);
// Nothing more is asked. Laws of friction, memory and play have details that no two engines share and may leave as much
// as passes for noise; smooth laws have none, and what one leaves above the noise has a cause of its own.
bool is_complete(const Trial& trial, const Trial& nominal);

// Best first, with probabilities: by cost and what every effect and parameter has to earn; among those that leave noise
// (or details) only, the simplest that the recordings they were not fitted to cannot tell from the best.
void sort_by_preference(const Trial& nominal, std::vector<Trial>* list);

}  // namespace hrp::diagnosis
