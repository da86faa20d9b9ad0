// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/outcome.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/search/fit.h"
#include "diagnosis/search/significance.h"
#include "diagnosis/search/starts.h"

namespace hrp::diagnosis {
namespace {

// Adds the systematic parts to the intervals. The residual above the noise may be correlated with a parameter in every
// stretch. Integrators and details of laws agree to kAgreement at best.
void widen(size_t recordings, Trial* trial) {
  const double above = std::max(0.0, 1.0 - trial->train.count / std::max(1.0, trial->train.chi2));
  const double shift = above * trial->train.count / static_cast<double>(kIndependent * std::max<size_t>(1, recordings));
  for (size_t i = 0; i < std::min(trial->std.size(), trial->hypothesis.size()); ++i) {
    for (size_t k = 0; k < trial->hypothesis[i].p.size(); ++k) {
      double& spread = trial->std[i][k];
      spread = std::hypot(spread * std::sqrt(1.0 + shift), kAgreement * trial->hypothesis[i].p[k]);
    }
  }
}

// Takes the next best explanation if the chosen one is not significant.
void take_next(Trials* trials, Outcome* outcome) {
  const EffectSet worthless = make_set(outcome->chosen.hypothesis);
  outcome->chosen = trials->nominal();
  outcome->explained = false;
  for (const Trial* t : trials->sort()) {
    if (t->hypothesis.empty() || make_set(t->hypothesis) == worthless || !is_explained(*t, trials->nominal())) continue;
    outcome->chosen = *t;
    outcome->explained = true;
    outcome->chosen.probability = 0.5;  // it fits worse than the removed one
    trials->finish(&outcome->chosen);
    return;
  }
}

// Removes effects that are not significant. They only fit details of the others.
void drop_insignificant(const Searched& searched, Trials* trials, Outcome* outcome) {
  Trial& chosen = outcome->chosen;
  if (chosen.hypothesis.empty() || chosen.std.size() < chosen.hypothesis.size()) return;
  Hypothesis kept;
  bool changed = false;
  for (size_t i = 0; i < chosen.hypothesis.size(); ++i) {
    const Effect& effect = chosen.hypothesis[i];
    const bool significant = is_significant(effect, chosen.std[i], chosen.distance[i]);
    changed = changed || !significant;
    if (significant)
      kept.push_back(effect);
    else if (moves_link(effect) && get_rotor(effect) > 0.0)
      kept.push_back(make_part(effect, get_effect(effect.id).parts.front()));
  }
  if (!changed) return;
  if (kept.empty()) return take_next(trials, outcome);
  Trial trial = trials->fit_aside(kept);
  searched.progress("  without what is no more than nothing: " + get_label(searched.experiment, kept) +
                    describe(trial));
  // Without it, details of laws may exceed the noise; then nothing is named.
  trial.probability = chosen.probability;
  trials->finish(&trial);
  outcome->rivals.insert(outcome->rivals.begin(), trial);
  chosen = trial;
  outcome->explained = is_explained(chosen, trials->nominal());
}

// Chooses the simplest set among those that held-out recordings cannot distinguish from the best.
void decide(const Searched& searched, const Trials& trials, Outcome* outcome) {
  std::vector<Trial> list;
  for (const Trial* t : trials.sort()) list.push_back(*t);
  if (list.empty()) list.push_back(trials.nominal());
  sort_by_preference(trials.nominal(), &list);
  outcome->chosen = list.front();
  outcome->rivals = list;
  for (const Trial& t : searched.passed_over) {
    if (!trials.has(t.hypothesis) && outcome->rivals.size() < kRivals) outcome->rivals.push_back(t);
  }
  outcome->explained = is_explained(outcome->chosen, trials.nominal());
  for (size_t i = 1; i < list.size(); ++i) {
    if (list[i].probability > kDetail) outcome->indistinguishable.push_back(list[i]);
  }
}

// Fitted sets of `size` effects with a smaller held-out error than `limit`, best first.
std::vector<const Trial*> list_close(const Outcome& outcome, size_t size, double limit) {
  std::vector<const Trial*> list;
  for (const Trial& t : outcome.rivals) {
    if (t.refined && t.hypothesis.size() == size && t.rms < limit) list.push_back(&t);
  }
  std::stable_sort(list.begin(), list.end(), [](const Trial* a, const Trial* b) { return a->rms < b->rms; });
  return list;
}

// Where nothing is explained, what comes about as close as may be told gets its intervals.
void add_close_intervals(const Searched& searched, Trials* trials, Outcome* outcome) {
  if (outcome->explained || !find_told_closest(searched.problem, *outcome)) return;
  const double limit = (1.0 + kMinority) * (1.0 - kNearlyAll) * outcome->nominal.rms;
  for (Trial& t : outcome->rivals) {
    if (!t.refined || t.hypothesis.empty() || t.hypothesis.size() > kLargestSet || !(t.rms < limit)) continue;
    trials->finish(&t);
    widen(searched.problem.train.size(), &t);
    normalise(&t.hypothesis);
  }
}

}  // namespace

void choose_outcome(const Searched& searched, Trials* trials, Outcome* outcome) {
  outcome->best = trials->best().hypothesis;
  decide(searched, *trials, outcome);
  trials->finish(&outcome->chosen);
  drop_insignificant(searched, trials, outcome);
  outcome->explained = is_explained(outcome->chosen, trials->nominal());
  widen(searched.problem.train.size(), &outcome->chosen);
  normalise(&outcome->chosen.hypothesis);
  add_close_intervals(searched, trials, outcome);
}

const Trial* find_closest(const Outcome& outcome) {
  for (size_t size = 1; size <= kLargestSet; ++size) {
    const std::vector<const Trial*> close = list_close(outcome, size, (1.0 - kNearlyAll) * outcome.nominal.rms);
    if (close.empty()) continue;
    const std::vector<const Trial*> equal = list_close(outcome, size, (1.0 + kDetail) * close.front()->rms);
    return *std::min_element(equal.begin(), equal.end(), [](const Trial* a, const Trial* b) {
      return count_parameters(a->hypothesis) < count_parameters(b->hypothesis);
    });
  }
  return nullptr;
}

std::vector<const Trial*> list_as_close(const Outcome& outcome, const Trial& closest) {
  std::vector<const Trial*> list = list_close(outcome, closest.hypothesis.size(), (1.0 + kMinority) * closest.rms);
  list.erase(std::remove_if(list.begin(), list.end(),
                            [&](const Trial* t) { return make_set(t->hypothesis) == make_set(closest.hypothesis); }),
             list.end());
  return list;
}

const Trial* find_told_closest(const Problem& problem, const Outcome& outcome) {
  return problem.validate.empty() || is_effort_driven(*problem.experiment) ? nullptr : find_closest(outcome);
}

}  // namespace hrp::diagnosis
