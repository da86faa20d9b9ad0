// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/effort_limits.h"

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/measurement/load_or_unit.h"

namespace hrp::diagnosis {
namespace {

constexpr int kTried = 40;  // limits between the median effort and the largest
// Columns of UnitRows::nuisance: the direction, the acceleration.
constexpr long kDry = 1, kRotor = 2;

// What one limit leaves of the missing torque, the share of the effort beyond it that is missing, and dry friction
// beside it.
struct AtLimit {
  double limit = 0.0, left = 0.0, share = 0.0, dry = 0.0;
};

// Least squares of the missing torque. A rotor below zero would take the model's own inertia away: it is then left out.
// With nothing but the effort that is there, a limit near zero would explain all.
AtLimit solve(Eigen::MatrixXd columns, const Eigen::VectorXd& missing, double limit) {
  Eigen::VectorXd x = columns.colPivHouseholderQr().solve(missing);
  if (x[kRotor] < 0.0) {
    columns.col(kRotor).setZero();
    x = columns.colPivHouseholderQr().solve(missing);
  }
  return {limit, (missing - columns * x).squaredNorm(), x[x.size() - 1], x[kDry]};
}

class Search {
 public:
  explicit Search(const UnitRows& rows)
      : effort_(rows.effort), missing_(rows.effort - rows.tau), columns_(rows.effort.size(), kNuisance + 2) {
    columns_ << rows.nuisance, rows.tau.cwiseAbs().cwiseProduct(rows.nuisance.col(1)),
        Eigen::VectorXd::Zero(rows.effort.size());
  }

  AtLimit try_limit(double limit) {
    columns_.col(columns_.cols() - 1) = effort_ - effort_.cwiseMax(-limit).cwiseMin(limit);
    return solve(columns_, missing_, limit);
  }

  // The best of kTried limits from `begin` on.
  AtLimit scan(double begin, double step, AtLimit best) {
    for (int i = 0; i < kTried; ++i) {
      const double limit = begin + i * step;
      const AtLimit at = limit > 0.0 ? try_limit(limit) : best;
      if (at.left < best.left) best = at;
    }
    return best;
  }

 private:
  const Eigen::VectorXd effort_, missing_;
  Eigen::MatrixXd columns_;  // friction, rotor, constant; friction of the load; effort beyond the limit
};

}  // namespace

std::vector<double> find_limits(const TorqueData& data, int joint) {
  // A servo's law is no log of what was asked for: its limit is stated.
  if (data.source[static_cast<size_t>(joint)] != EffortSource::kRecorded) return {};
  const UnitRows rows = collect_efforts(data, joint);
  if (rows.effort.size() < kRowsPerColumn * (kNuisance + 2)) return {};
  const Eigen::VectorXd size = rows.effort.cwiseAbs();
  const double most = size.maxCoeff(), median = find_quantile({size.begin(), size.end()}, kHalf),
               step = (most - median) / kTried;
  Search search(rows);
  const AtLimit without = search.try_limit(most);
  AtLimit best = search.scan(median, step, without);
  best = search.scan(best.limit - step, 2.0 * step / kTried, best);
  const bool whole = best.share > kMostly && best.share < 1.0 / kMostly;
  // A drive that gives no more than its joint's friction, which varies by a fifth, does not move the joint: friction
  // that holds it for most of the time takes as much as the drive gives.
  const bool moves = best.dry < kMostly * best.limit;
  return whole && moves && best.left < kDetail * without.left ? std::vector<double>{best.limit} : std::vector<double>{};
}

}  // namespace hrp::diagnosis
