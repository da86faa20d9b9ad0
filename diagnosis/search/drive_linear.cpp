// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/drive_linear.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

constexpr int kFolds = 4, kDealt = 12;  // stretches per recording, dealt to the folds in turn
constexpr int kBlocks = 24;                 // stretches per recording whose scatter tells the spread of parameters

// Gauss-Newton step. `variance` of a residual weighs the data against the parameters' widths.
Eigen::VectorXd solve_step(const Sums& sums, const Eigen::VectorXd& width, Eigen::MatrixXd* inverse) {
  const double variance = std::max(1.0, sums.c / std::max(1.0, sums.count));
  Eigen::MatrixXd A = sums.G;
  for (long i = 0; i < A.rows(); ++i) A(i, i) += variance / (width[i] * width[i]);
  const Eigen::LDLT<Eigen::MatrixXd> factor(A);
  if (inverse) *inverse = factor.solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  return factor.solve(-sums.b);
}

Sums select(const Sums& all, const std::vector<long>& columns) {
  Sums part;
  const long p = static_cast<long>(columns.size());
  part.G.resize(p, p), part.b.resize(p);
  for (long i = 0; i < p; ++i) {
    part.b[i] = all.b[columns[static_cast<size_t>(i)]];
    for (long j = 0; j < p; ++j) part.G(i, j) = all.G(columns[static_cast<size_t>(i)], columns[static_cast<size_t>(j)]);
  }
  part.c = all.c, part.count = all.count;
  return part;
}

}  // namespace

std::vector<Slot> list_slots(const Hypothesis& hypothesis) {
  return flatten<EffectParameter>(
      hypothesis, [](const Effect& e) -> const auto& { return list_infos(e.id); },
      [](size_t, const EffectParameter& info) { return !info.scanned; });
}

Linear linearise(const Problem& problem, const Hypothesis& hypothesis, const std::vector<Slot>& slots,
                 const std::vector<int>& recordings) {
  Linear linear;
  linear.recordings = recordings;
  linear.width.resize(static_cast<long>(slots.size()));
  for (int recording : recordings) {
    std::vector<double> residuals, moved;
    if (!calc_residuals(problem, hypothesis, recording, &residuals)) return linear;
    const long rows = static_cast<long>(residuals.size());
    linear.r.push_back(Eigen::Map<const Eigen::VectorXd>(residuals.data(), rows));
    Eigen::MatrixXd J(rows, static_cast<long>(slots.size()));
    for (size_t s = 0; s < slots.size(); ++s) {
      Hypothesis variant = hypothesis;
      double& value = variant[slots[s].effect].p[slots[s].index];
      const EffectParameter& info = *slots[s].info;
      const double size = std::max(info.step, std::abs(value));
      // 2 % of its size: over sticking and slipping, readings follow friction with a jagged trend.
      const double delta = value + 0.02 * size > info.high ? -0.02 * size : 0.02 * size;
      linear.width[static_cast<long>(s)] = 3.0 * size;
      value += delta;
      if (!calc_residuals(problem, variant, recording, &moved)) return linear;
      J.col(static_cast<long>(s)) = (Eigen::Map<const Eigen::VectorXd>(moved.data(), rows) - linear.r.back()) / delta;
    }
    linear.J.push_back(std::move(J));
  }
  linear.ok = true;
  return linear;
}

Linear extend(const Problem& problem, const Linear& linear, const Hypothesis& model, const Effect& candidate) {
  Hypothesis with = model;
  with.push_back(candidate);
  std::vector<Slot> added;
  for (const Slot& slot : list_slots(with)) {
    if (slot.effect + 1 == with.size()) added.push_back(slot);
  }
  const Linear more = linearise(problem, with, added, linear.recordings);
  if (!more.ok) return more;
  Linear both = linear;
  const long own = linear.width.size(), extra = more.width.size();
  both.width.conservativeResize(own + extra);
  both.width.tail(extra) = more.width;
  for (size_t r = 0; r < both.J.size(); ++r) {
    both.J[r].conservativeResize(Eigen::NoChange, own + extra);
    both.J[r].rightCols(extra) = more.J[r];
  }
  return both;
}

void Sums::add(const Sums& other, double factor) {
  if (G.size() == 0) G.setZero(other.G.rows(), other.G.cols()), b.setZero(other.b.size());
  G += factor * other.G, b += factor * other.b, c += factor * other.c, count += factor * other.count;
}

std::vector<Sums> sum_groups(const Linear& linear, int groups, const GroupOf& group_of) {
  const long p = linear.width.size();
  std::vector<Sums> sums(static_cast<size_t>(groups));
  for (Sums& s : sums) s.G.setZero(p, p), s.b.setZero(p);
  for (size_t i = 0; i < linear.r.size(); ++i) {
    const long samples = linear.r[i].size() / kQuantities;
    for (long k = 0; k < samples; ++k) {
      const int group = group_of(i, static_cast<size_t>(k));
      if (group < 0) continue;
      Sums& s = sums[static_cast<size_t>(group)];
      const auto J = linear.J[i].middleRows(k * kQuantities, kQuantities);
      const auto r = linear.r[i].segment(k * kQuantities, kQuantities);
      s.G.noalias() += J.transpose() * J;
      s.b.noalias() += J.transpose() * r;
      s.c += r.squaredNorm();
      for (long q = 0; q < kQuantities; ++q) s.count += r[q] != 0.0 ? 1.0 : 0.0;
    }
  }
  return sums;
}

std::vector<Sums> sum_folds(const Linear& linear) {
  return sum_groups(linear, kFolds, [&](size_t i, size_t k) {
    const size_t samples = static_cast<size_t>(linear.r[i].size()) / kQuantities;
    return static_cast<int>(k * kDealt / samples) % kFolds;
  });
}

double cross_validate(const std::vector<Sums>& folds, const std::vector<long>& columns, const Eigen::VectorXd& width) {
  std::vector<Sums> parts;
  Sums all;
  Eigen::VectorXd w(static_cast<long>(columns.size()));
  for (size_t i = 0; i < columns.size(); ++i) w[static_cast<long>(i)] = width[columns[i]];
  for (const Sums& fold : folds) parts.push_back(select(fold, columns)), all.add(parts.back(), 1.0);
  double total = 0.0;
  for (const Sums& part : parts) {
    Sums others = all;
    others.add(part, -1.0);
    const Eigen::VectorXd step = solve_step(others, w, nullptr);
    total += part.c + 2.0 * part.b.dot(step) + step.dot(part.G * step);
  }
  return total;
}

bool calc_part_step(const Linear& linear, const GroupOf& part, int which, PartStep* out) {
  const int recordings = static_cast<int>(linear.r.size());
  const std::vector<Sums> blocks = sum_groups(linear, recordings * kBlocks, [&](size_t i, size_t k) {
    if (part(i, k) != which) return -1;
    const size_t samples = static_cast<size_t>(linear.r[i].size()) / kQuantities;
    return static_cast<int>(i) * kBlocks + static_cast<int>(k * kBlocks / samples);
  });
  Sums all;
  int filled = 0;
  for (const Sums& block : blocks) all.add(block, 1.0), filled += block.count > 0.0 ? 1 : 0;
  if (filled < 4 || all.count < 60.0) return false;
  Eigen::MatrixXd inverse;
  out->step = solve_step(all, linear.width, &inverse);
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  for (const Sums& block : blocks) {
    const Eigen::VectorXd score = block.b + block.G * out->step;
    scatter += score * score.transpose();
  }
  // Few blocks: the scatter about a mean that was fitted to them is too small by their number over their freedom.
  const double freedom = std::max(1.0, filled - static_cast<double>(inverse.rows()));
  const Eigen::MatrixXd covariance = inverse * scatter * inverse * (filled / freedom);
  out->sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  return true;
}

}  // namespace hrp::diagnosis
