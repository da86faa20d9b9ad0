// SPDX-License-Identifier: BSD-3-Clause
// What rows tell of a fit's coefficients beside their values: errors, values by part, and how alike two effects are.
#include <algorithm>
#include <map>

#include "diagnosis/estimate/robust.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/floating/fit/least_squares.h"
#include "diagnosis/floating/fit/normal_equations.h"

namespace hrp::diagnosis::floating {
namespace {

// [s] By recording: half of its time.
std::map<int, double> find_middles(const std::vector<ChannelRows>& channels) {
  std::map<int, double> middle;
  for (const ChannelRows& rows : channels) {
    std::map<int, std::pair<double, double>> ends;
    for (size_t i = 0; i < rows.rows(); ++i) {
      auto& e = ends.try_emplace(rows.recording[i], 1e300, -1e300).first->second;
      e.first = std::min(e.first, rows.time[i]);
      e.second = std::max(e.second, rows.time[i]);
    }
    for (const auto& [r, e] : ends) middle[r] = 0.5 * (e.first + e.second);
  }
  return middle;
}

}  // namespace

Eigen::MatrixXd LeggedFitter::calc_covariance(const LeggedFit& fit, bool all) const {
  const long n = fit.x.size();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n), scatter = A;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  std::map<int, Eigen::VectorXd> scores;  // by block
  for (size_t c = 0; c < channels().size(); ++c) {
    add_normal(Part::kTrain, c, fit.effects, &A, &b);
    if (all) add_normal(Part::kHeld, c, fit.effects, &A, &b);
    const Eigen::MatrixXd X = calc_columns(c, fit.effects, false), D = calc_columns(c, fit.effects, true);
    const std::vector<double> r = calc_residuals(fit, c), e = calc_residuals(fit, c, true);
    for (size_t i = 0; i < r.size(); ++i) {
      if (!all && is_held(c, i)) continue;
      auto at = scores.try_emplace(channels()[c].block[i], Eigen::VectorXd::Zero(n)).first;
      const auto k = static_cast<long>(i);
      at->second += get_weight(c, i) * (r[i] * X.row(k) - e[i] * D.row(k)).transpose();
    }
  }
  for (const auto& [block, s] : scores) scatter += s * s.transpose();
  A = Eigen::MatrixXd(A.selfadjointView<Eigen::Lower>());
  // What is known beforehand is one more observation, of value 0: its score is as uncertain as it is.
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(n, n);
  add_priors(fit.effects, &known, &b);
  add_priors(fit.effects, &A, &b);
  scatter += known;
  A.diagonal() *= 1 + kRidge;
  const auto blocks = static_cast<double>(scores.size());
  const double few = blocks > static_cast<double>(n) + 1 ? blocks / (blocks - static_cast<double>(n)) : blocks;
  const Eigen::MatrixXd inverse = A.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  return make_robust_covariance(inverse, scatter, few).robust;
}

Eigen::VectorXd LeggedFitter::calc_systematic(const LeggedFit& fit) const {
  const long n = fit.x.size();
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(n), shift = squares;
  for (size_t c = 0; c < channels().size(); ++c) {
    const Eigen::MatrixXd X = calc_columns(c, fit.effects, false);
    Eigen::VectorXd in_line = Eigen::VectorXd::Zero(n);
    for (size_t i = 0; i < channels()[c].rows(); ++i) {
      if (is_held(c, i)) continue;
      const Eigen::VectorXd x = X.row(static_cast<long>(i)).transpose();
      squares += get_weight(c, i) * x.cwiseAbs2();
      in_line += get_weight(c, i) * find_exactness(c) * x.cwiseAbs();
    }
    shift += in_line.cwiseAbs2();
  }
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd none = Eigen::VectorXd::Zero(n);
  add_priors(fit.effects, &known, &none);
  return shift.cwiseSqrt().cwiseQuotient((squares + known.diagonal()).cwiseMax(1e-300));
}

std::map<int, LeggedFitter::Normal> LeggedFitter::sum_parts(const LeggedFit& fit, size_t effect) const {
  const std::vector<Candidate> one{fit.effects[effect]};
  const long n = count_coefficients(one);
  const Eigen::VectorXd so_far = fit.x.segment(static_cast<long>(fit.find_first(effect)), n);
  const std::map<int, double> middle = find_middles(channels());
  const bool halves = middle.size() < 3;
  std::map<int, Normal> normal;
  for (size_t c = 0; c < channels().size(); ++c) {
    const Eigen::MatrixXd X = calc_columns(c, one, false), D = calc_columns(c, one, true);
    if (X.isZero(0)) continue;
    const std::vector<double> r = calc_residuals(fit, c), e = calc_residuals(fit, c, true);
    const ChannelRows& rows = channels()[c];
    for (size_t i = 0; i < r.size(); ++i) {
      const int part = 2 * rows.recording[i] + (halves && rows.time[i] > middle.at(rows.recording[i]));
      auto& [A, b] = normal.try_emplace(part, Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)).first->second;
      const Eigen::VectorXd x = X.row(static_cast<long>(i)).transpose(), d = D.row(static_cast<long>(i)).transpose();
      const double w = get_weight(c, i);
      A += w * (x * x.transpose() - d * d.transpose());
      b += w * (x * (r[i] + x.dot(so_far)) - d * (e[i] + d.dot(so_far)));
    }
  }
  return normal;
}

std::vector<LeggedFitter::PartFit> LeggedFitter::fit_parts(const LeggedFit& fit, size_t effect) const {
  const std::vector<Candidate> one{fit.effects[effect]};
  std::map<int, Normal> normal = sum_parts(fit, effect);
  Eigen::VectorXd most = Eigen::VectorXd::Zero(count_coefficients(one)), total = most;
  for (const auto& [part, ab] : normal) most = most.cwiseMax(ab.first.diagonal());
  const std::vector<long> core = find_core(one[0]);
  std::vector<PartFit> out;
  for (auto& [part, ab] : normal) {
    // A part in which the effect hardly shows says nothing of its size.
    const auto shows = [&, &A = ab.first](long k) { return A(k, k) > kMinor * most(k); };
    if (std::none_of(core.begin(), core.end(), shows)) continue;
    add_prior(one[0].prior, 0, &ab.first, &ab.second);
    out.push_back({solve_scaled(ab.first, ab.second), ab.first.diagonal().cwiseMax(0)});
    total += out.back().weight;
  }
  for (PartFit& p : out) p.weight = p.weight.cwiseQuotient(total.cwiseMax(1e-300));
  return out;
}

double LeggedFitter::calc_overlap(const Candidate& a, const Candidate& b) const {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (size_t c = 0; c < channels().size(); ++c) {
    const Eigen::MatrixXd X = calc_columns(c, {a, b}, false), D = calc_columns(c, {a, b}, true);
    for (long i = 0; i < X.rows(); ++i) {
      sum +=
          get_weight(c, static_cast<size_t>(i)) * (X.row(i).transpose() * X.row(i) - D.row(i).transpose() * D.row(i));
    }
  }
  return sum(0, 0) > 0 && sum(1, 1) > 0 ? sum(0, 1) * sum(0, 1) / (sum(0, 0) * sum(1, 1)) : 0;
}

}  // namespace hrp::diagnosis::floating
