// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/gain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/fit/candidate_laws.h"

namespace hrp::diagnosis::floating {
namespace {

// [n log] The best of some hundred candidates gains 12 on the fitted rows by chance.
constexpr double kCost = 30;
constexpr double kCostOfCoefficient = 4;  // [n log] of each further coefficient
constexpr double kDeviations = 2.5;       // robust standard errors that a value must exceed
constexpr double kMoreDeviations = 1;     // for a vector, whose length is positive by chance alone

// Robust covariance of one effect's coefficients, from all rows.
Eigen::MatrixXd calc_own_covariance(const SearchState& state, const LeggedFit& fit, size_t effect) {
  const auto first = static_cast<long>(fit.find_first(effect)), n = static_cast<long>(fit.effects[effect].terms.size());
  return state.fitter.calc_covariance(fit, true).block(first, first, n, n);
}

bool is_told(double x, double variance) { return std::abs(x) > kDeviations * std::sqrt(std::max(0.0, variance)); }

// The equation with the largest gain.
template <class Gain>
size_t find_most(const SearchState& state, const Gain& calc_gain) {
  size_t best = 0;
  double most = -1e300;
  for (size_t c = 0; c < state.fitter.channels().size(); ++c) {
    const double gain = calc_gain(c);
    if (gain > most) {
      most = gain;
      best = c;
    }
  }
  return best;
}

}  // namespace

double calc_cost(const Candidate& candidate) {
  return kCost + kCostOfCoefficient * static_cast<double>(candidate.terms.size() - 1);
}

double calc_total_gain(const SearchState& state, const LeggedFit& without, const LeggedFit& with) {
  return state.fitter.calc_gain(Part::kTrain, without, with) + state.fitter.calc_gain(Part::kHeld, without, with);
}

double calc_own_held_gain(const SearchState& state, const LeggedFit& without, size_t effect) {
  double sum = 0;
  for (size_t c = 0; c < state.fitter.channels().size(); ++c) {
    if (state.fitter.changes(c, state.chosen.effects[effect]))
      sum += state.fitter.calc_gain(Part::kHeld, c, without, state.chosen);
  }
  return sum;
}

size_t find_main_channel(const SearchState& state, const LeggedFit& without, const LeggedFit& with) {
  return find_most(state, [&](size_t c) {
    return state.fitter.calc_gain(Part::kHeld, c, without, with) +
           state.fitter.calc_gain(Part::kTrain, c, without, with);
  });
}

size_t find_lasting_channel(const SearchState& state, const LeggedFit& with) {
  return find_most(state, [&](size_t c) { return state.fitter.calc_gain_after(c, state.chosen, with); });
}

double calc_share(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel) {
  const double after = with.signed_square[1][channel];
  const double before = state.nominal.signed_square[1][channel] - std::min(0.0, after);
  return before > 0 ? (without.signed_square[1][channel] - after) / before : 0;
}

bool matters(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel) {
  if (calc_share(state, without, with, channel) > kDetail) return true;
  const double after = with.signed_square[1][channel],
               before = without.signed_square[1][channel] - std::min(0.0, after);
  const double gone = before - std::max(0.0, after);
  double largest = 0;
  for (size_t c = 0; c < state.fitter.channels().size(); ++c) {
    const bool same_unit = state.fitter.channels()[c].info.unit == state.fitter.channels()[channel].info.unit;
    if (same_unit) largest = std::max(largest, state.nominal.mean_square[1][c]);
  }
  return gone > kHalf * before && gone > kBlur * kBlur * largest;
}

bool is_large_enough(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel) {
  const double worth = with.effects.back().law->worth;
  if (worth <= 0) return true;
  const double gone = without.mean_square[1][channel] - with.mean_square[1][channel];
  return std::sqrt(std::max(0.0, gone)) > worth * state.fitter.channels()[channel].scale;
}

bool is_possible(const SearchState& state, const LeggedFit& fit, size_t effect) {
  const Candidate& c = fit.effects[effect];
  Eigen::VectorXd x = fit.get(effect);
  const bool any_below = std::any_of(c.law->core.begin(), c.law->core.end(), [&](long k) { return x(k) < 0; });
  if (any_below && x.allFinite()) {
    const Eigen::MatrixXd own = calc_own_covariance(state, fit, effect);
    for (const long k : c.law->core) {
      if (x(k) < 0 && !is_told(x(k), own(k, k))) x(k) = 0;
    }
  }
  return is_sensible(c, x);
}

bool is_significant(const SearchState& state, const LeggedFit& fit, size_t effect) {
  const Eigen::MatrixXd own = calc_own_covariance(state, fit, effect);
  const Eigen::VectorXd x = fit.get(effect);
  const Candidate& c = fit.effects[effect];
  if (c.calc_size(x) < c.least) return false;
  if (c.vector) return std::sqrt(std::max(0.0, x.dot(own.ldlt().solve(x)))) > kDeviations + kMoreDeviations;
  const std::vector<long> core = find_core(c);
  return std::any_of(core.begin(), core.end(), [&](long k) { return is_told(x(k), own(k, k)); });
}

}  // namespace hrp::diagnosis::floating
