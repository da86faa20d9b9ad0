// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/trials.h"

#include <algorithm>
#include <cmath>

#include "common/base/format.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/nearby.h"
#include "diagnosis/search/start_state.h"
#include "diagnosis/search/starts.h"
#include "diagnosis/search/step_error.h"

namespace hrp::diagnosis {
namespace {

bool is_better(const Trial& a, const Trial& b) {
  return a.train.ok && b.train.ok ? calc_cost(a) < calc_cost(b) : a.train.ok && !b.train.ok;
}

}  // namespace

std::string describe(const Trial& trial) {
  return ": train " + format("%.4g, held out %.4g, worst signal %.4g", trial.train.rms(), trial.rms, trial.worst);
}

Trials::Trials(const Problem& problem, const Progress& progress)
    : problem_(problem), progress_(progress), held_out_(get_judged(problem)) {
  for (size_t r = 0; r < problem.experiment->recordings.size(); ++r) all_.push_back(static_cast<int>(r));
  const Trial& nominal = trials_[{}] = judge({}, refine({}));
  progress_("nominal" + describe(nominal));
  best_chi2_ = nominal.train.chi2;
}

std::vector<const Trial*> Trials::sort() const {
  std::vector<const Trial*> list;
  for (const auto& item : trials_) {
    if (item.second.refined) list.push_back(&item.second);
  }
  std::stable_sort(list.begin(), list.end(), [](const Trial* a, const Trial* b) { return is_better(*a, *b); });
  return list;
}

const Trial& Trials::best() const {
  const std::vector<const Trial*> list = sort();
  return list.empty() ? nominal() : *list.front();
}

bool Trials::is_refused(const Hypothesis& hypothesis) const {
  return std::any_of(hypothesis.begin(), hypothesis.end(), [&](const Effect& e) {
    return refused_.count({e.id, e.place}) > 0;
  });
}

void Trials::add(const Hypothesis& start) {
  if (is_refused(start)) return;
  const FitResult result = refine(start);
  if (refuse(result)) return progress_("  * " + get_label(*problem_.experiment, start) + ": too few ripples");
  Trial trial = judge(start, result);
  if (trial.refined) best_chi2_ = std::min(best_chi2_, trial.train.chi2);
  progress_("  * " + get_label(*problem_.experiment, start) + describe(trial));
  const auto known = trials_.find(make_set(start));
  if (known == trials_.end() || is_better(trial, known->second)) trials_[make_set(start)] = trial;
}

Trial Trials::fit_aside(const Hypothesis& start) { return judge(start, refine(start)); }

const Problem& Trials::take_up(const Trial& trial) {
  problem_.starts = trial.starts;
  problem_.step_errors = trial.step_errors;
  return problem_;
}

std::vector<Effect> Trials::choose(const Trial& from, size_t at, const std::vector<Effect>& options, size_t count) {
  take_up(from);
  problem_.step_errors.clear();
  return choose_options(problem_, problem_.train, from.full(), at, options, count);
}

// Polishing may bring the right set to the noise by start states and pre-sliding displacements alone. Larger sets would
// cost ten times as much.
void Trials::polish_best() {
  const Trial& first = best();
  const bool near = first.rms < kAboveNoise || is_detail(first, nominal());
  if (first.hypothesis.empty() || is_explained(first, nominal()) || !near) return;
  polish(&trials_.at(make_set(first.hypothesis)));
}

// A trial far from the noise would not reach it. It is not named, so only its intervals are computed.
void Trials::finish(Trial* trial) {
  if (trial->hypothesis.empty() || !trial->refined || !trial->std.empty()) return;
  if (trial->rms < kFarMore || is_detail(*trial, nominal())) polish(trial);
  if (trial->std.empty()) add_intervals(trial);
}

double Trials::find_range(int joint, std::vector<double> SmoothJoint::*series) const {
  double low = 1e300, high = -1e300;
  for (int r : problem_.train) {
    const std::vector<double>& x = problem_.smooth[static_cast<size_t>(r)].joints[static_cast<size_t>(joint)].*series;
    low = std::min(low, *std::min_element(x.begin(), x.end()));
    high = std::max(high, *std::max_element(x.begin(), x.end()));
  }
  return high - low;
}

FitResult Trials::refine(const Hypothesis& hypothesis) {
  Hypothesis start = hypothesis;
  for (const EffectInfo& row : list_effects()) {
    if (!is_timing_row(row)) continue;
    const std::vector<double> none(row.parameters.size(), 0.0);
    // of the subtree that starts there
    if (row.place == PlaceKind::kNone) start.push_back({row.id, at_joint(0), none});
    for (const Effect& effect : hypothesis) {
      if (row.place == PlaceKind::kJoint && moves_link(effect)) start.push_back({row.id, effect.place, none});
    }
  }
  FitOptions options;
  options.max_iterations = 15;
  options.abandon_above = 25.0 * best_chi2_;
  problem_.starts = estimate_starts(problem_, start, all_);
  problem_.step_errors.clear();
  FitResult rough = fit(problem_, start, problem_.train, options);
  if (!rough.ok || (!hypothesis.empty() && rough.train.rms() > kTenTimes)) return rough;
  // Friction next to new effects may need another pre-sliding displacement.
  const double finest = rough.train.rms() > kFarMore ? kCoarseFactor : kFinestFactor;
  const Hypothesis bent = try_nearby(problem_, rough.hypothesis, finest);
  problem_.step_errors = estimate_step_errors(problem_, bent, all_, kFiner);
  const FitResult fine = fit(problem_, bent, problem_.train, options);
  return fine.ok ? fine : rough;
}

Trial Trials::judge(const Hypothesis& hypothesis, const FitResult& result) const {
  Trial trial;
  trial.hypothesis = hypothesis;
  if (!result.ok) return trial;
  trial.hypothesis = result.hypothesis;
  const auto timing = std::find_if(trial.hypothesis.begin(), trial.hypothesis.end(), is_timing);
  trial.refined = timing != trial.hypothesis.end();
  trial.timing.assign(timing, trial.hypothesis.end());
  trial.hypothesis.erase(timing, trial.hypothesis.end());
  trial.train = result.train;
  trial.starts = problem_.starts;
  trial.step_errors = problem_.step_errors;
  trial.validate = calc_score(problem_, trial.full(), held_out_);
  if (!trial.validate.ok) return trial;
  trial.rms = trial.validate.rms();
  trial.worst = trial.validate.worst();
  return trial;
}

// With less than two ripples over the motion, the effect is any smooth function of position, not cogging.
bool Trials::ripples(const Effect& effect) const {
  const int periods = get_effect(effect.id).periods;
  return periods < 0 ||
         effect.p[static_cast<size_t>(periods)] * find_range(effect.place.index, &SmoothJoint::q) > 4.0 * M_PI;
}

// Refuses effects that the fit changed into something else; no later set may contain them.
bool Trials::refuse(const FitResult& result) {
  for (const Effect& effect : result.hypothesis) {
    if (result.ok && !ripples(effect)) refused_.insert({effect.id, effect.place});
  }
  return is_refused(result.hypothesis);
}

// Intervals of a trial with its parameters unchanged.
void Trials::add_intervals(Trial* trial) {
  FitOptions options;
  options.max_iterations = 0;
  options.intervals = true;
  const FitResult result = fit(take_up(*trial), trial->full(), problem_.train, options);
  trial->std = result.std;
  trial->distance = result.distance;
}

// Fits start states, pre-sliding displacements and parameters in turn, then computes the intervals.
void Trials::polish(Trial* trial) {
  FitOptions options;
  options.max_iterations = 8;
  options.tolerance = 1e-7;
  FitResult result;
  result.hypothesis = trial->full();
  for (int round = 0; round < kFewRounds; ++round) {
    problem_.starts = estimate_starts(problem_, result.hypothesis, all_);
    problem_.step_errors.clear();
    const Hypothesis start = try_nearby(problem_, result.hypothesis);
    problem_.step_errors = estimate_step_errors(problem_, start, all_, kFiner);
    options.intervals = round + 1 == kFewRounds;
    result = fit(problem_, start, problem_.train, options);
    if (!result.ok) return;
  }
  Trial better = judge(trial->hypothesis, result);
  if (better.rms > 1.02 * trial->rms) return;
  progress_("  finished: " + get_label(*problem_.experiment, trial->hypothesis) + describe(better));
  better.std = result.std;
  better.distance = result.distance;
  better.probability = trial->probability;
  *trial = better;
}

}  // namespace hrp::diagnosis
