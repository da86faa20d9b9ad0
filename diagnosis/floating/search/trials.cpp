// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/trials.h"

#include <algorithm>

#include "common/base/has.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/fit/remaining.h"
#include "diagnosis/floating/search/gain.h"

namespace hrp::diagnosis::floating {
namespace {

constexpr double kFittedGain = 3;  // [n log] that a candidate wins at least on fitted rows, before its cost

// Two effects of one family at one place, such as a wrong mass and a load of a link, would share what one explains.
bool is_same_kind(const Candidate& a, const Candidate& b) {
  return a.is_listed() && b.is_listed() && a.where == b.where && a.place == b.place &&
         a.info().family == b.info().family;
}

// A free law without the terms whose columns are noise alone. A robot that never moves sideways shows no change of a
// force with its sideways place.
Candidate keep_told(const SearchState& state, Candidate c) {
  const std::vector<Terms> all = c.terms;
  std::vector<Terms> told;
  for (const Terms& t : all) {
    c.terms = {t};
    if (state.fitter.fit({c}).x.allFinite()) told.push_back(t);
  }
  c.terms = told.empty() ? all : told;
  return c;
}

bool is_open(const SearchState& state, const LeggedFit& base, const Candidate& c, Pool pool) {
  if (is_banned(state, c) || c.is_listed() != (pool == Pool::kListed)) return false;
  return std::none_of(base.effects.begin(), base.effects.end(),
                      [&](const Candidate& e) { return is_same(e, c) || is_same_kind(e, c); });
}

std::vector<LeggedTrial> try_each(const SearchState& state, const LeggedFit& base, Pool pool) {
  std::vector<LeggedTrial> out;
  for (const Candidate& c : state.candidates) {
    if (!is_open(state, base, c, pool)) continue;
    std::vector<Candidate> effects = base.effects;
    effects.push_back(pool == Pool::kFree ? keep_told(state, c) : c);
    LeggedTrial t;
    t.fit = fit_effects(state, std::move(effects));
    if (!is_possible(state, t.fit, t.at())) continue;
    t.gain = state.fitter.calc_gain(Part::kTrain, base, t.fit) - calc_cost(c);
    t.held = state.fitter.calc_gain(Part::kHeld, base, t.fit);
    t.channel = find_main_channel(state, base, t.fit);
    out.push_back(std::move(t));
  }
  return out;
}

}  // namespace

bool is_confirmed(const LeggedTrial& t) {
  return t.gain + calc_cost(t.added()) > kFittedGain && t.held > kLeastHeldGain && t.gain + t.held > 0;
}

std::vector<LeggedTrial> list_trials(const SearchState& state, const LeggedFit& base, Pool pool,
                                     const std::function<bool(const LeggedTrial&)>& is_kept) {
  std::vector<LeggedTrial> out;
  for (LeggedTrial& t : try_each(state, base, pool)) {
    if (is_kept(t)) out.push_back(std::move(t));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const LeggedTrial& a, const LeggedTrial& b) { return a.gain + a.held > b.gain + b.held; });
  return out;
}

std::vector<LeggedTrial> list_confirmed(const SearchState& state, const LeggedFit& base, Pool pool) {
  return list_trials(state, base, pool, is_confirmed);
}

std::vector<LeggedTrial> list_lasting(const SearchState& state) {
  std::vector<LeggedTrial> out;
  for (LeggedTrial& t : try_each(state, state.chosen, Pool::kListed)) {
    const size_t channel = t.channel = find_lasting_channel(state, t.fit);
    // Where a dropped effect helped an equation, all others would be tried there in turn. Soles lie a little askew all
    // the time, which is no effect.
    const bool tried = has(state.unsteady, channel);
    if (tried || is_of_soles(state.fitter.channels()[channel].info)) continue;
    if (t.held <= 0 || calc_share(state, state.chosen, t.fit, channel) < kHalf) continue;
    t.held = 0;
    t.gain = state.fitter.calc_gain_after(state.chosen, t.fit) - calc_cost(t.added());
    if (t.gain > 0) out.push_back(std::move(t));
  }
  std::stable_sort(out.begin(), out.end(), [](const LeggedTrial& a, const LeggedTrial& b) { return a.gain > b.gain; });
  return out;
}

}  // namespace hrp::diagnosis::floating
