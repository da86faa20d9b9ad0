// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/description.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/floating/fit/candidate_laws.h"
#include "diagnosis/floating/fit/regimes.h"
#include "diagnosis/floating/search/deviations.h"
#include "diagnosis/floating/search/gain.h"
#include "diagnosis/floating/search/rivals.h"

namespace hrp::diagnosis::floating {
namespace {

// Standard error of an effect's size, 1 as in the fit, to which other equations confirm it: then it is neither none nor
// twice as large by chance.

// Whether the effect is a zero of one of several force sensors.
bool is_one_zero_of_many(const SearchState& state, const Candidate& c) {
  if (c.place < 0 || c.place >= state.layout.sensors || state.layout.sensors < 2 || c.terms.empty() ||
      c.terms[0].empty())
    return false;
  const int column = c.terms[0][0].first, first = state.layout.sensor(c.place, kForceBiasColumn);
  return column >= first && column < first + 3;
}

// Whether all equations but the one that shows an effect most ask for it in the same size, from half to twice. The sum
// of the feet's forces tells how large a zero is, and not whose. Their moments about the base tell whose.
bool is_confirmed_elsewhere(const SearchState& state, size_t effect, size_t channel) {
  const Eigen::VectorXd x = state.chosen.get(effect);
  const auto [all, covariance] = state.fitter.fit_without(state.chosen.effects, channel);
  if (!all.allFinite() || !covariance.allFinite() || !(x.squaredNorm() > 0)) return false;
  const auto first = static_cast<long>(state.chosen.find_first(effect)), n = x.size();
  const double size = x.dot(all.segment(first, n)) / x.squaredNorm();
  const double variance = x.dot(covariance.block(first, first, n, n) * x);
  const double std = std::sqrt(std::max(0.0, variance)) / x.squaredNorm();
  return size > 0.5 && size < 2 && std < kPart;
}

// The mean of what an effect takes away beside all others, and of what it takes away alone.
double calc_fair_share(const SearchState& state, const LeggedFit& rest, const FoundEffect& f) {
  const LeggedFit alone = fit_effects(state, {f.effect});
  const double beside = calc_share(state, rest, state.chosen, f.channel);
  return std::clamp(0.5 * (beside + calc_share(state, state.nominal, alone, f.channel)), 0.0, 1.0);
}

// What phases differ by beyond chance has a cause that nothing explains: the value is no better known.
Eigen::VectorXd calc_stated_deviation(const SearchState& state, const LeggedFit& fit, size_t i, bool all) {
  const double by_phase = find_phase_spread(list_regimes(state.fitter, fit, i, state.layout)) / kNinetyFive;
  return calc_deviation(state, fit, i, all).cwiseMax(by_phase * fit.get(i).cwiseAbs());
}

FoundEffect describe_effect(const SearchState& state, size_t i) {
  const LeggedFit& chosen = state.chosen;
  const LeggedFit rest = fit_without(state, i);
  FoundEffect f;
  f.effect = chosen.effects[i];
  f.x = chosen.get(i);
  f.std = calc_stated_deviation(state, chosen, i, false);
  f.scatter = calc_scatter(state, chosen, i);
  f.spread = calc_spread(state, chosen, i);
  f.channel = find_main_channel(state, rest, chosen);
  f.gain = calc_total_gain(state, rest, chosen);
  f.share = calc_fair_share(state, rest, f);
  f.rivals = list_rivals(state, rest, f);
  f.sums_up = is_one_zero_of_many(state, f.effect) && !is_confirmed_elsewhere(state, i, f.channel);
  return f;
}

}  // namespace

std::vector<FoundEffect> describe_effects(const SearchState& state) {
  std::vector<FoundEffect> out;
  for (size_t i = 0; i < state.chosen.effects.size(); ++i) out.push_back(describe_effect(state, i));
  return out;
}

void measure_by_all(const SearchState& state, std::vector<FoundEffect>* effects) {
  const LeggedFit all = state.fitter.fit(state.chosen.effects, true);
  for (size_t i = 0; i < effects->size(); ++i) {
    FoundEffect& f = (*effects)[i];
    const Eigen::VectorXd x = all.get(i), std = calc_stated_deviation(state, all, i, true);
    if (make_estimates(f.effect, x, std).size() == make_estimates(f.effect, f.x, f.std).size()) {
      f.x = x;
      f.std = std;
    }
  }
}

}  // namespace hrp::diagnosis::floating
