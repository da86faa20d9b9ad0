// SPDX-License-Identifier: BSD-3-Clause
// The sets of effects that were fitted through the simulation, with their start states and step errors.
#pragma once

#include <map>
#include <set>

#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

// Errors of a trial, for the progress.
std::string describe(const Trial& trial);

// Fits sets of effects and keeps the best fit of each set.
class Trials {
 public:
  // Fits the nominal model.
  Trials(const Problem& problem, const Progress& progress);

  const Trial& nominal() const { return trials_.at({}); }
  bool has(const Hypothesis& hypothesis) const { return trials_.count(make_set(hypothesis)) > 0; }
  // Completely fitted trials, best first; the best one (nominal if there is no other).
  std::vector<const Trial*> sort() const;
  const Trial& best() const;

  // True for sets with an effect that turned into another one in an earlier fit.
  bool is_refused(const Hypothesis& hypothesis) const;
  // Fits a set from its parameters as start values. Keeps the result unless a better one of the set is known.
  void add(const Hypothesis& start);
  // The same without keeping it.
  Trial fit_aside(const Hypothesis& start);
  // Best options for one effect of a trial, from the trial's start states (choose_options() of starts.h).
  std::vector<Effect> choose(const Trial& from, size_t at, const std::vector<Effect>& options, size_t count);
  // Polishes the best trial if only that may keep it from the noise.
  void polish_best();
  // Polishes a trial if that may help, and computes its intervals.
  void finish(Trial* trial);
  // The problem with a trial's start states and step errors.
  const Problem& take_up(const Trial& trial);
  // Range of a joint's series in the training recordings.
  double find_range(int joint, std::vector<double> SmoothJoint::*series) const;

 private:
  FitResult refine(const Hypothesis& hypothesis);
  Trial judge(const Hypothesis& hypothesis, const FitResult& result) const;
  bool ripples(const Effect& effect) const;
  bool refuse(const FitResult& result);
  void polish(Trial* trial);
  void add_intervals(Trial* trial);

  Problem problem_;  // with the start states of the current trial
  Progress progress_;
  std::vector<int> all_, held_out_;
  std::map<EffectSet, Trial> trials_;             // the nominal one, too
  std::set<std::pair<EffectId, Place>> refused_;  // with an effect that a fit changed into another one
  double best_chi2_ = 1e300;
};

}  // namespace hrp::diagnosis
