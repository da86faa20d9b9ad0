// SPDX-License-Identifier: BSD-3-Clause
// The sets of effects that were fitted through the simulation, with the start states and steps that suit each.
#pragma once

#include <map>
#include <set>

#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

// How well a trial does, for the progress.
std::string describe(const Trial& trial);

class Trials {
 public:
  // Fits the model without any effect.
  Trials(const Problem& problem, const Progress& progress);

  const Trial& nominal() const { return trials_.at({}); }
  bool has(const Hypothesis& hypothesis) const { return trials_.count(make_set(hypothesis)) > 0; }
  // Those that were fitted, best first; the best (the nominal one where nothing else was).
  std::vector<const Trial*> sort() const;
  const Trial& best() const;

  // Sets that no fit is worth: an effect of them became something else in another fit.
  bool is_refused(const Hypothesis& hypothesis) const;
  // Fits a set from where its parameters are; keeps it unless it is known from better ones.
  void add(const Hypothesis& start);
  // The same without keeping it.
  Trial fit_aside(const Hypothesis& start);
  // Of options for one effect of a trial, the best from the trial's start states (choose_options() of starts.h).
  std::vector<Effect> choose(const Trial& from, size_t at, const std::vector<Effect>& options, size_t count);
  // Polishes the best one if that may be all that keeps it from the noise.
  void polish_best();
  // Polishes a trial if that may help, and gives it its intervals.
  void finish(Trial* trial);
  // The problem with a trial's start states and steps.
  const Problem& take_up(const Trial& trial);
  // Between the largest and the least value of a joint's motion in the recordings that are fitted.
  double find_range(int joint, std::vector<double> SmoothJoint::*series) const;

 private:
  FitResult refine(const Hypothesis& hypothesis);
  Trial judge(const Hypothesis& hypothesis, const FitResult& result) const;
  bool ripples(const Effect& effect) const;
  bool refuse(const FitResult& result);
  void polish(Trial* trial);
  void add_intervals(Trial* trial);

  Problem problem_;  // with the start states of the trial at work
  Progress progress_;
  std::vector<int> all_, held_out_;
  std::map<EffectSet, Trial> trials_;      // the nominal one, too
  std::set<std::pair<EffectId, Place>> refused_;  // effects and places
  double best_chi2_ = 1e300;
};

}  // namespace hrp::diagnosis
