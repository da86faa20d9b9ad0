// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/search/deviations.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/robust.h"

namespace hrp::diagnosis::floating {
namespace {

using PartFit = LeggedFitter::PartFit;

// Variance of a coefficient by what recordings differ by: the parts' differences from the whole, each with its share of
// the information, widened because there are few parts.
double calc_variance_between(const std::vector<PartFit>& parts, double value, long k) {
  double weighted = 0;
  for (const PartFit& p : parts) weighted += std::pow(p.weight(k) * (p.x(k) - value), 2);
  const auto n = static_cast<double>(parts.size());
  return std::pow(find_widening(parts.size()), 2) * weighted * n / (n - 1);
}

}  // namespace

Eigen::VectorXd calc_scatter(const SearchState& state, const LeggedFit& fit, size_t effect) {
  const auto first = static_cast<long>(fit.find_first(effect)), n = static_cast<long>(fit.effects[effect].terms.size());
  Eigen::VectorXd variance = state.fitter.calc_covariance(fit).diagonal().segment(first, n).cwiseMax(0);
  const std::vector<PartFit> parts = state.fitter.fit_parts(fit, effect);
  Eigen::VectorXd between = Eigen::VectorXd::Zero(n);
  for (const PartFit& p : parts) between += (p.x - fit.get(effect)).cwiseAbs2();
  const auto count = static_cast<double>(parts.size());
  if (count > 1) variance = variance.cwiseMax(between / (count * (count - 1)));
  return variance.cwiseSqrt();
}

Eigen::VectorXd calc_deviation(const SearchState& state, const LeggedFit& fit, size_t effect, bool all) {
  const Eigen::MatrixXd covariance = state.fitter.calc_covariance(fit, all);
  const auto first = static_cast<long>(fit.find_first(effect));
  const Eigen::VectorXd x = fit.get(effect), systematic = state.fitter.calc_systematic(fit);
  const std::vector<PartFit> parts = state.fitter.fit_parts(fit, effect);
  Eigen::VectorXd out(x.size());
  for (long k = 0; k < x.size(); ++k) {
    double variance = std::max(0.0, covariance(first + k, first + k));
    if (parts.size() > 1) variance = std::max(variance, calc_variance_between(parts, x(k), k));
    out(k) = std::hypot(std::sqrt(variance), systematic(first + k));
  }
  return out;
}

double calc_spread(const SearchState& state, const LeggedFit& fit, size_t effect) {
  const std::vector<PartFit> parts = state.fitter.fit_parts(fit, effect);
  if (parts.size() < 2) return 0;
  const double value = fit.get(effect)(0);
  double sum = 0;
  for (const PartFit& p : parts) sum += std::pow(p.x(0) - value, 2);
  return std::sqrt(sum / (static_cast<double>(parts.size()) - 1)) / std::max(1e-300, std::abs(value));
}

}  // namespace hrp::diagnosis::floating
