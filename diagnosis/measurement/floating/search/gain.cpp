// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/search/gain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/measurement/floating/candidate_laws.h"

namespace hrp::diagnosis::floating {
namespace {

// [n log] The best of some hundred candidates gains 12 on the fitted rows by chance.
constexpr double kCost = 30;
constexpr double kCostOfCoefficient = 4;  // [n log] of each further coefficient
constexpr double kDeviations = 2.5;       // robust standard errors that a value must exceed
constexpr double kMoreDeviations = 1;     // for a vector, whose length is positive by chance alone

}  // namespace

double calc_cost(const Candidate& candidate) {
  return kCost + kCostOfCoefficient * static_cast<double>(candidate.terms.size() - 1);
}

double calc_total_gain(const SearchState& state, const LeggedFit& without, const LeggedFit& with) {
  return state.fitter.calc_gain(Part::kTrain, without, with) + state.fitter.calc_gain(Part::kHeld, without, with);
}

size_t find_main_channel(const SearchState& state, const LeggedFit& without, const LeggedFit& with) {
  size_t best = 0;
  double most = -1e300;
  for (size_t c = 0; c < state.fitter.channels().size(); ++c) {
    const double gain =
        state.fitter.calc_gain(Part::kHeld, c, without, with) + state.fitter.calc_gain(Part::kTrain, c, without, with);
    if (gain > most) most = gain, best = c;
  }
  return best;
}

double calc_share(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel) {
  const double after = with.signed_square[1][channel];
  const double before = state.nominal.signed_square[1][channel] - std::min(0.0, after);
  return before > 0 ? (without.signed_square[1][channel] - after) / before : 0;
}

bool is_large_enough(const SearchState& state, const LeggedFit& without, const LeggedFit& with, size_t channel) {
  const double worth = with.effects.back().law->worth;
  if (worth <= 0) return true;
  const double gone = without.mean_square[1][channel] - with.mean_square[1][channel];
  return std::sqrt(std::max(0.0, gone)) > worth * state.fitter.channels()[channel].scale;
}

bool is_significant(const SearchState& state, const LeggedFit& fit, size_t effect) {
  const Eigen::MatrixXd all = state.fitter.calc_covariance(fit, true);
  const auto first = static_cast<long>(fit.find_first(effect)), n = static_cast<long>(fit.effects[effect].terms.size());
  const Eigen::VectorXd x = fit.get(effect);
  const Candidate& c = fit.effects[effect];
  if (c.calc_size(x) < c.least) return false;
  if (!c.vector) return std::abs(x(0)) > kDeviations * std::sqrt(std::max(0.0, all(first, first)));
  const Eigen::MatrixXd own = all.block(first, first, n, n);
  return std::sqrt(std::max(0.0, x.dot(own.ldlt().solve(x)))) > kDeviations + kMoreDeviations;
}

}  // namespace hrp::diagnosis::floating
