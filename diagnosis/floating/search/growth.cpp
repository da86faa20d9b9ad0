// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/growth.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/search/gain.h"
#include "diagnosis/floating/search/trials.h"
#include "diagnosis/model/made.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr size_t kMostEffects = 24;  // far more than any recording has shown
constexpr double kStay = 0.6;  // share of its cost and of the least held-out gain that an effect must keep to stay

// Adds the first of these candidates, best first, that takes a share of its equation's mismatch and is not chance.
bool add_best(const std::vector<LeggedTrial>& trials, double least_share, SearchState* state) {
  for (const LeggedTrial& t : trials) {
    const bool large = calc_share(*state, state->chosen, t.fit, t.channel) >= least_share;
    if (!large && !(t.added().is_listed() && matters(*state, state->chosen, t.fit, t.channel))) continue;
    if (!is_significant(*state, t.fit, t.at()) || !is_large_enough(*state, state->chosen, t.fit, t.channel)) continue;
    say_of(*state, "gain " + std::to_string(std::lround(t.gain + t.held)) + " by", t.added());
    settle(t.fit.effects, state);
    return true;
  }
  return false;
}

bool add(SearchState* state) {
  if (state->chosen.effects.size() >= kMostEffects) return false;
  return add_best(list_confirmed(*state, state->chosen, Pool::kListed), kDetail, state) ||
         add_best(list_lasting(*state), kHalf, state);
}

// Whether a chosen effect still explains something that the others do not, with a possible value.
bool is_needed(const SearchState& state, size_t effect, const LeggedFit& rest) {
  const LeggedFit& chosen = state.chosen;
  const Candidate& c = chosen.effects[effect];
  const double gain = state.fitter.calc_gain(Part::kTrain, rest, chosen) - kStay * calc_cost(c);
  const double held = state.fitter.calc_gain(Part::kHeld, rest, chosen);
  const bool wins = gain + held > 0 && calc_own_held_gain(state, rest, effect) > kStay * kLeastHeldGain;
  if (!wins || !is_possible(state, chosen, effect)) return false;
  const size_t channel = find_main_channel(state, rest, chosen);
  return (!c.is_listed() || matters(state, rest, chosen, channel)) && is_significant(state, chosen, effect);
}

// Takes out what the others explain by now, and what the others have made impossible. Begins again after each.
void prune(SearchState* state) {
  for (size_t i = state->chosen.effects.size(); i-- > 0;) {
    const LeggedFit rest = fit_without(*state, i);
    if (is_needed(*state, i, rest)) continue;
    say_of(*state, "without", state->chosen.effects[i]);
    settle(rest.effects, state);
    i = state->chosen.effects.size();
  }
}

// Tries all candidates in the place of each effect: it was chosen before the others were known.
bool exchange(Pool pool, SearchState* state) {
  bool any = false;
  for (size_t i = 0; i < state->chosen.effects.size(); ++i) {
    const LeggedFit rest = fit_without(*state, i);
    const std::vector<LeggedTrial> trials = list_confirmed(*state, rest, pool);
    if (trials.empty()) continue;
    const double before = calc_total_gain(*state, rest, state->chosen) - calc_cost(state->chosen.effects[i]);
    // A tie is the listed effect's: a scenario can hold it.
    const double margin = pool == Pool::kFree ? std::max(kTie, kDetail * before) : kTie;
    const LeggedTrial& best = trials[0];
    if (best.gain + best.held < before + margin || !is_significant(*state, best.fit, best.at())) continue;
    say_of(*state, "exchanged for", best.added());
    settle(best.fit.effects, state);
    any = true;
  }
  return any;
}

// Whether its size alone speaks against an effect by more than what gains decide by: the zero of an encoder, or half of
// a gap, that is many times what joints are made and calibrated to. Odds of a large error fall with its square
// (Cauchy), so that none is impossible.
bool is_odd(const Candidate& c, const Eigen::VectorXd& x) {
  const LawTable& laws = get_laws();
  if (c.law != &laws.joint_offset && c.law != &laws.backlash) return false;
  const double angle = c.law == &laws.backlash ? kHalf * x(0) : x(0);
  return 2 * std::log1p(std::pow(angle / kMountingError, 2)) > kTie;
}

// Puts an effect of a usual size in the place of one whose size is odd, if it explains as much. A robot that hardly
// turns shows a displaced mass, a wrong zero and play that always leans to one side as the same constant moment.
bool exchange_odd(SearchState* state) {
  for (size_t i = 0; i < state->chosen.effects.size(); ++i) {
    if (!is_odd(state->chosen.effects[i], state->chosen.get(i))) continue;
    const LeggedFit rest = fit_without(*state, i);
    const double before = calc_total_gain(*state, rest, state->chosen),
                 least = before - std::max(kTie, kDetail * before);
    for (const LeggedTrial& t : list_confirmed(*state, rest, Pool::kListed)) {
      if (t.gain + t.held + calc_cost(t.added()) < least || is_odd(t.added(), t.fit.get(t.at()))) continue;
      if (!is_significant(*state, t.fit, t.at())) continue;
      say_of(*state, "of a usual size:", t.added());
      settle(t.fit.effects, state);
      return true;
    }
  }
  return false;
}

bool merge_two(size_t first, size_t second, SearchState* state) {
  const std::vector<Candidate>& chosen = state->chosen.effects;
  std::vector<Candidate> others;
  for (size_t i = 0; i < chosen.size(); ++i) {
    if (i != first && i != second) others.push_back(chosen[i]);
  }
  const LeggedFit rest = fit_effects(*state, others);
  const std::vector<LeggedTrial> trials = list_confirmed(*state, rest, Pool::kListed);
  if (trials.empty()) return false;
  const double costs = calc_cost(chosen[first]) + calc_cost(chosen[second]);
  const double both = calc_total_gain(*state, rest, state->chosen) - costs;
  const LeggedTrial& best = trials[0];
  if (best.gain + best.held < both || !is_significant(*state, best.fit, best.at())) return false;
  say_of(*state, "one for two:", best.added());
  settle(best.fit.effects, state);
  return true;
}

// Replaces two effects of one family, such as masses of two links, by a single one that wins as much. The first of them
// was chosen while the other was not known. It then stood in for some of the other in an equation that both change:
// frictions of two joints do not, and every drive of a real robot has one.
bool merge_any(SearchState* state) {
  const std::vector<Candidate>& chosen = state->chosen.effects;
  for (size_t i = 0; i < chosen.size(); ++i) {
    for (size_t k = i + 1; k < chosen.size(); ++k) {
      if (!chosen[i].is_listed() || !chosen[k].is_listed()) continue;
      if (chosen[i].info().family != chosen[k].info().family) continue;
      if (!state->fitter.have_common_equation(chosen[i], chosen[k])) continue;
      if (merge_two(i, k, state)) return true;
    }
  }
  return false;
}

double calc_costs(const LeggedFit& fit) {
  double sum = 0;
  for (const Candidate& c : fit.effects) sum += calc_cost(c);
  return sum;
}

double calc_score(const SearchState& state, const LeggedFit& fit) {
  return calc_total_gain(state, state.nominal, fit) - calc_costs(fit);
}

// The last effect of `all` beside those that it needs: takes the others out in turn, at least two, and returns the set
// that wins most; `all` where there is none.
LeggedFit keep_needed(const SearchState& state, const LeggedFit& all) {
  LeggedFit left = all, out = all;
  double most = -1e300;
  while (left.effects.size() > 1) {
    LeggedFit next;
    double score = -1e300;
    for (size_t i = 0; i + 1 < left.effects.size(); ++i) {
      std::vector<Candidate> rest = left.effects;
      rest.erase(rest.begin() + static_cast<long>(i));
      const LeggedFit fit = fit_effects(state, std::move(rest));
      if (calc_score(state, fit) > score) {
        score = calc_score(state, fit);
        next = fit;
      }
    }
    if (next.effects.empty()) break;
    left = next;
    if (left.effects.size() + 2 <= all.effects.size() && score > most) {
      most = score;
      out = left;
    }
  }
  return out;
}

// Puts one free law in the place of several effects. Effects that stand in for physics outside the table share it among
// them, so that the free law in the place of any single one wins little. One cause is likelier than several: a law that
// explains as much, within what makes rivals, wins by the costs of the others.
bool replace_several(SearchState* state) {
  if (state->chosen.effects.size() < 2) return false;
  const double before = calc_total_gain(*state, state->nominal, state->chosen);
  double best = calc_score(*state, state->chosen);
  LeggedFit found;
  for (const LeggedTrial& t : list_confirmed(*state, state->nominal, Pool::kFree)) {
    std::vector<Candidate> effects = state->chosen.effects;
    const auto is_it = [&](const Candidate& c) { return is_same(c, t.added()); };
    if (std::any_of(effects.begin(), effects.end(), is_it)) continue;
    effects.push_back(t.added());
    const LeggedFit with = keep_needed(*state, fit_effects(*state, std::move(effects)));
    if (with.effects.size() >= state->chosen.effects.size()) continue;
    const double gain = calc_total_gain(*state, state->nominal, with);
    if (gain < before - std::max(kTie, kDetail * before) || calc_score(*state, with) < best) continue;
    if (!is_possible(*state, with, with.effects.size() - 1) || !is_significant(*state, with, with.effects.size() - 1))
      continue;
    best = calc_score(*state, with);
    found = with;
  }
  if (found.effects.empty()) return false;
  say_of(*state, "one for several:", found.effects.back());
  settle(found.effects, state);
  return true;
}

}  // namespace

void grow_listed(SearchState* state) {
  while (add(state)) {
  }
  prune(state);
  exchange(Pool::kListed, state);
  while (merge_any(state)) {
  }
  while (exchange_odd(state)) {
  }
  prune(state);
}

void grow_free(SearchState* state) {
  bool exchanged = replace_several(state);
  exchanged = exchange(Pool::kFree, state) || exchanged;
  const bool added = state->chosen.effects.size() < kMostEffects &&
                     add_best(list_confirmed(*state, state->chosen, Pool::kFree), kDetail, state);
  if (exchanged || added) prune(state);
}

}  // namespace hrp::diagnosis::floating
