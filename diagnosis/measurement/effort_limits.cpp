// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/effort_limits.h"

#include <algorithm>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/rows_per_column.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/load_or_unit.h"

namespace hrp::diagnosis {
namespace {

constexpr int kTried = 40;            // limits between the median effort and the largest
constexpr long kBeside = kNuisance + 2;  // friction, rotor, constant; load and friction of the load

// What one limit leaves, and the share of the effort beyond it that is missing.
struct AtLimit {
  double limit = 0.0, left = 0.0, share = 0.0;
};

AtLimit try_limit(const Eigen::MatrixXd& basis, const Eigen::VectorXd& effort, const Eigen::VectorXd& left, double limit) {
  const Eigen::VectorXd over = effort - effort.cwiseMax(-limit).cwiseMin(limit), own = over - basis * (basis.transpose() * over);
  const double oo = own.squaredNorm(), ol = own.dot(left);
  return {limit, left.squaredNorm() - (oo > 0.0 ? ol * ol / oo : 0.0), oo > 0.0 ? ol / oo : 0.0};
}

}  // namespace

std::vector<double> find_limits(const TorqueData& data, int joint) {
  // A servo's law is no log of what was asked for: its limit is stated.
  if (data.source[static_cast<size_t>(joint)] != EffortSource::kRecorded) return {};
  const UnitRows rows = collect_efforts(data, joint);
  const long n = rows.effort.size();
  if (n < kRowsPerColumn * (kBeside + 1)) return {};
  Eigen::MatrixXd beside(n, kBeside);
  beside << rows.nuisance, rows.tau, rows.tau.cwiseAbs().cwiseProduct(rows.nuisance.col(1));
  const Eigen::MatrixXd basis = beside.colPivHouseholderQr().householderQ() * Eigen::MatrixXd::Identity(n, kBeside);
  const Eigen::VectorXd left = rows.effort - basis * (basis.transpose() * rows.effort);
  const Eigen::VectorXd size = rows.effort.cwiseAbs();
  const double median = find_quantile({size.begin(), size.end()}, kHalf), step = (size.maxCoeff() - median) / kTried;
  AtLimit best{0.0, left.squaredNorm(), 0.0};
  for (int i = 0; i < kTried; ++i) {
    const AtLimit at = try_limit(basis, rows.effort, left, median + i * step);
    if (at.left < best.left) best = at;
  }
  for (int i = 1 - kTried; i < kTried; ++i) {
    const AtLimit at = try_limit(basis, rows.effort, left, best.limit + i * step / kTried);
    if (at.left < best.left) best = at;
  }
  const bool whole = best.share > kMostly && best.share < 1.0 / kMostly;
  return whole && best.left < kHalf * left.squaredNorm() ? std::vector<double>{best.limit} : std::vector<double>{};
}

}  // namespace hrp::diagnosis
