// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/held_feet/search.h"

#include "diagnosis/estimate/robust.h"

namespace hrp::diagnosis::held_feet {
namespace {

constexpr double kBlock = 0.5;  // [s] what is left is correlated over tenths of a second at most

// A column of the fit: its value is hypothesis[effect].p[index].
struct RowSlot {
  size_t effect, index;
  Coordinate info;
};
using Parameters = std::vector<RowSlot>;

Parameters list_parameters(const RowHypothesis& hypothesis) {
  Parameters out;
  for (size_t e = 0; e < hypothesis.size(); ++e) {
    const std::vector<Coordinate> infos = list_coordinates(hypothesis[e].id, hypothesis[e].place);
    for (size_t i = 0; i < infos.size(); ++i) out.push_back({e, i, infos[i]});
  }
  return out;
}

// Whitened rows of all recordings; 0 where there is none.
std::vector<Eigen::VectorXd> calc_whitened(const RowProblem& problem, const RowHypothesis& hypothesis) {
  const size_t n = problem.sigma.size();
  std::vector<Eigen::VectorXd> out;
  for (size_t r = 0; r < problem.recordings.size(); ++r) {
    const std::vector<double> rows = calc_rows(problem, hypothesis, r);
    Eigen::VectorXd w(static_cast<long>(rows.size()));
    for (size_t i = 0; i < rows.size(); ++i) {
      const double sigma = problem.sigma[i % n];
      w[static_cast<long>(i)] = std::isfinite(rows[i]) && sigma > 0.0 ? rows[i] / sigma : 0.0;
    }
    out.push_back(std::move(w));
  }
  return out;
}

// Columns of all parameters by differences.
std::vector<Eigen::MatrixXd> calc_columns(const RowProblem& problem, const RowHypothesis& hypothesis,
                                          const Parameters& parameters, const std::vector<Eigen::VectorXd>& rows) {
  std::vector<Eigen::MatrixXd> J;
  for (const Eigen::VectorXd& r : rows) J.emplace_back(r.size(), static_cast<long>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    RowHypothesis moved = hypothesis;
    moved[parameters[i].effect].p[parameters[i].index] += parameters[i].info.step;
    const std::vector<Eigen::VectorXd> there = calc_whitened(problem, moved);
    for (size_t r = 0; r < rows.size(); ++r)
      J[r].col(static_cast<long>(i)) = (there[r] - rows[r]) / parameters[i].info.step;
  }
  return J;
}

// Solves for a step that leaves parameters with a sign on their side: the worst offender is pinned until none is left.
Eigen::VectorXd solve_signed(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, const Parameters& parameters,
                             const RowHypothesis& hypothesis) {
  const long n = b.size();
  std::vector<char> pinned(static_cast<size_t>(n), 0);
  Eigen::VectorXd x;
  for (long round = 0; round <= n; ++round) {
    Eigen::MatrixXd M = A;
    Eigen::VectorXd y = b;
    for (long i = 0; i < n; ++i) {
      if (!pinned[static_cast<size_t>(i)]) continue;
      const RowSlot& p = parameters[static_cast<size_t>(i)];
      const double to = p.info.neutral - hypothesis[p.effect].p[p.index];
      y -= A.col(i) * to;
      M.row(i).setZero(), M.col(i).setZero();
      M(i, i) = 1.0;
      y[i] = to;
    }
    for (long i = 0; i < n; ++i) {
      if (!pinned[static_cast<size_t>(i)]) continue;
      y[i] = parameters[static_cast<size_t>(i)].info.neutral -
             hypothesis[parameters[static_cast<size_t>(i)].effect].p[parameters[static_cast<size_t>(i)].index];
    }
    M.diagonal().array() += 1e-12 * (1e-12 + M.diagonal().array());
    x = M.ldlt().solve(y);
    long worst = -1;
    double depth = 1e-12;
    for (long i = 0; i < n; ++i) {
      const RowSlot& p = parameters[static_cast<size_t>(i)];
      if (!p.info.positive || pinned[static_cast<size_t>(i)]) continue;
      const double below = (p.info.neutral - hypothesis[p.effect].p[p.index] - x[i]) * std::sqrt(A(i, i));
      if (below > depth) depth = below, worst = i;
    }
    if (worst < 0) break;
    pinned[static_cast<size_t>(worst)] = 1;
  }
  return x;
}

struct Sums {
  Eigen::MatrixXd A, scores;
  Eigen::VectorXd b;
};

Sums sum_blocks(const std::vector<RowBlock>& blocks, const std::vector<char>& use, size_t joints,
                const std::vector<Eigen::VectorXd>& rows, const std::vector<Eigen::MatrixXd>& J) {
  const long n = J[0].cols();
  Sums out{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, static_cast<long>(blocks.size())),
           Eigen::VectorXd::Zero(n)};
  for (size_t k = 0; k < blocks.size(); ++k) {
    if (!use[k]) continue;
    const auto from = static_cast<long>(blocks[k].first * joints),
               count = static_cast<long>((blocks[k].end - blocks[k].first) * joints);
    const auto part = J[blocks[k].recording].middleRows(from, count);
    const Eigen::VectorXd score = part.transpose() * rows[blocks[k].recording].segment(from, count);
    out.A += part.transpose() * part, out.b += score;
    out.scores.col(static_cast<long>(k)) = score;
  }
  return out;
}

void fill_score(const std::vector<RowBlock>& blocks, const std::vector<char>& use, size_t joints,
                const std::vector<Eigen::VectorXd>& rows, RowFit* fit) {
  double chi2[2] = {0, 0}, count[2] = {0, 0};
  fit->chi2.assign(blocks.size(), 0.0);
  for (size_t k = 0; k < blocks.size(); ++k) {
    const auto from = static_cast<long>(blocks[k].first * joints),
               size = static_cast<long>((blocks[k].end - blocks[k].first) * joints);
    const Eigen::VectorXd part = rows[blocks[k].recording].segment(from, size);
    const double sum = part.squaredNorm(), n = static_cast<double>((part.array() != 0.0).count());
    fit->chi2[k] = sum;
    const size_t role = use[k] ? 1 : 0;
    chi2[role] += sum, count[role] += n;
  }
  fit->train = count[1] > 0 ? std::sqrt(chi2[1] / count[1]) : 0.0;
  fit->held = count[0] > 0 ? std::sqrt(chi2[0] / count[0]) : 0.0;
}

}  // namespace

std::vector<RowBlock> list_blocks(const RowProblem& problem) {
  std::vector<RowBlock> blocks;
  const auto size = static_cast<size_t>(std::max(1.0, std::round(kBlock / problem.step)));
  for (size_t r = 0; r < problem.recordings.size(); ++r) {
    const size_t count = problem.recordings[r].time.size();
    for (size_t first = 0; first < count; first += size) blocks.push_back({r, first, std::min(count, first + size)});
  }
  return blocks;
}

RowFit fit_rows(const RowProblem& problem, const RowHypothesis& start, const std::vector<char>& use) {
  RowFit fit;
  fit.hypothesis = start;
  const std::vector<RowBlock> blocks = list_blocks(problem);
  const Parameters parameters = list_parameters(start);
  const size_t joints = problem.sigma.size();
  std::vector<Eigen::VectorXd> rows = calc_whitened(problem, fit.hypothesis);
  fill_score(blocks, use, joints, rows, &fit);
  // The rows are linear in almost everything: again for the products (scale times bias, offsets).
  for (int round = 0; round < 3 && !parameters.empty(); ++round) {
    const Sums sums = sum_blocks(blocks, use, joints, rows, calc_columns(problem, fit.hypothesis, parameters, rows));
    const Eigen::VectorXd step = solve_signed(sums.A, -sums.b, parameters, fit.hypothesis);
    for (size_t i = 0; i < parameters.size(); ++i)
      fit.hypothesis[parameters[i].effect].p[parameters[i].index] += step[static_cast<long>(i)];
    rows = calc_whitened(problem, fit.hypothesis);
    fill_score(blocks, use, joints, rows, &fit);
  }
  for (const RowEffect& e : fit.hypothesis) fit.std.emplace_back(e.p.size(), 0.0);
  if (!parameters.empty()) {
    const Sums sums = sum_blocks(blocks, use, joints, rows, calc_columns(problem, fit.hypothesis, parameters, rows));
    Eigen::MatrixXd A = sums.A;
    A.diagonal().array() += 1e-12 * (1e-12 + A.diagonal().array());
    const Eigen::MatrixXd inverse = A.ldlt().solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
    const RobustCovariance covariance = make_robust_covariance(inverse, sums.scores * sums.scores.transpose());
    for (size_t i = 0; i < parameters.size(); ++i) {
      fit.std[parameters[i].effect][parameters[i].index] = std::sqrt(covariance.find_variance(static_cast<long>(i)));
    }
  }
  return fit;
}

}  // namespace hrp::diagnosis::held_feet
