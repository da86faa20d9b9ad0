// SPDX-License-Identifier: BSD-3-Clause
// Fitted hypotheses and the preference among them.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// A hypothesis that was fitted to the training recordings and judged on the others.
struct Trial {
  Hypothesis hypothesis;                 // without the timing of the drives
  Hypothesis timing;                     // timing of the drives, by subtree; empty: without delay
  std::vector<std::vector<double>> std;  // by effect, by parameter
  std::vector<double> distance;          // by effect, see FitResult
  Starts starts;                         // of all recordings, under this hypothesis
  StepErrors step_errors;
  Score train, validate;
  double rms = 1e300;    // on held-out recordings [noise]
  double worst = 1e300;  // largest rms of one signal there
  double probability = 0.0;
  bool refined = false;         // fitted completely, with timing
  std::vector<Trial> subtrees;  // of a robot with several: start states and step errors
  Hypothesis full() const;      // with the timing
};

// Chi-square of all recordings.
double calc_cost(const Trial& trial);
size_t count_parameters(const Hypothesis& hypothesis);
// Standard deviations of one effect's parameters; 0 if the trial has none.
std::vector<double> get_std(const Trial& trial, size_t effect);

// Prior cost of a hypothesis in chi2: of effects, parameters, and factors far from one. `readings`: number in all
// recordings.
double calc_own_price(const Hypothesis& hypothesis, double readings);
// Odds of a hypothesis against the preferred one. `dearer`: difference of costs (chi2 in units of the best one's noise,
// plus prior costs). `more_parameters`: difference of parameters. calc_dearer: the inverse for two hypotheses, the
// difference at which the second one has this probability.
double calc_odds(double dearer, double more_parameters);
double calc_dearer(double probability);

// True if only noise is left.
bool is_noise(const Trial& trial);
// True if the residual is so small a share of the nominal one that it may be details of laws.
bool is_detail(const Trial& trial, const Trial& nominal);
// One of the two, and not the nominal model.
bool is_explained(const Trial& trial, const Trial& nominal);
// True if no further effect is needed. Laws of friction, memory and play differ in detail between engines, and may
// leave some noise-like residual. Smooth laws do not, so their residual above the noise has another cause.
bool is_complete(const Trial& trial, const Trial& nominal);

// Sorts best first and sets probabilities. The cost is chi2 plus prior costs. Among hypotheses that leave only noise
// (or details), the simplest one that held-out recordings cannot distinguish from the best comes first.
void sort_by_preference(const Trial& nominal, std::vector<Trial>* list);

}  // namespace hrp::diagnosis
