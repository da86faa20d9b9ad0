// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/effort_limits.h"

#include <cmath>
#include <limits>

#include "diagnosis/data/quantile.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {
namespace {

constexpr int kTried = 40;  // limits between the smallest that is looked for and the largest effort

// The part of the effort that is not there.
using CalcAbsent = Eigen::VectorXd (*)(const Eigen::VectorXd& effort, double limit);
Eigen::VectorXd calc_within(const Eigen::VectorXd& effort, double limit) {
  return effort.cwiseMax(-limit).cwiseMin(limit);
}
Eigen::VectorXd calc_beyond(const Eigen::VectorXd& effort, double limit) { return effort - calc_within(effort, limit); }

// What one limit leaves of the torque, the torque [N m] per logged unit, the share of the absent effort that is
// missing, and dry friction beside it.
struct AtLimit {
  double limit = 0.0, left = std::numeric_limits<double>::infinity(), scale = 1.0, share = 0.0, dry = 0.0;

  // All of it is missing.
  bool is_whole() const { return share > kMostly && share < 1.0 / kMostly; }
};

// Is the effort's unit known? One torque per logged unit, or any.
enum class Unit { kTorque, kAny };

class Search {
 public:
  Search(const UnitRows& rows, CalcAbsent calc_absent, Unit unit)
      : calc_absent_(calc_absent), any_unit_(unit == Unit::kAny), effort_(rows.effort), missing_(-rows.tau) {
    columns_.resize(effort_.size(), kNuisance + (any_unit_ ? 3 : 2));
    columns_ << rows.nuisance, rows.tau.cwiseAbs().cwiseProduct(rows.nuisance.col(kDry)),
        Eigen::MatrixXd::Zero(effort_.size(), columns_.cols() - kNuisance - 1);
    if (any_unit_)
      columns_.col(columns_.cols() - 2) = -effort_;
    else
      missing_ += effort_;
  }

  bool is_told() const { return effort_.size() >= kRowsPerColumn * columns_.cols(); }

  AtLimit try_limit(double limit) const {
    const Eigen::MatrixXd columns = make_columns(limit);
    const Eigen::VectorXd x = solve(columns);
    const double scale = any_unit_ ? x[x.size() - 2] : 1.0;
    return {limit, (missing_ - columns * x).squaredNorm(), scale, x[x.size() - 1] / scale, x[kDry]};
  }

  // The best limit between two quantiles of the efforts' sizes, if it takes nine tenths of the squares that are left
  // `without` it, and all of the absent effort is missing.
  AtLimit find(double from, double to, const AtLimit& without) const {
    const Eigen::VectorXd size = effort_.cwiseAbs();
    const double begin = find_quantile({size.begin(), size.end()}, from),
                 step = (find_quantile({size.begin(), size.end()}, to) - begin) / kTried;
    AtLimit best = scan(begin, step, without);
    best = scan(best.limit - step, 2.0 * step / kTried, best);
    return best.is_whole() && best.left < kDetail * without.left ? best : AtLimit{};
  }

  // True if the zone also explains the samples in which the drive brakes a joint that moves for sure. Elsewhere
  // friction that bends or sticks takes as much.
  bool explains_braking(const AtLimit& zone, const AtLimit& without) const {
    const Eigen::ArrayXd direction = columns_.col(kDry).array(),
                         brakes = (effort_.array() * direction < 0.0 && direction.abs() > kNearlyAll).cast<double>();
    const double left = (brakes * calc_left(zone).array()).square().sum();
    return brakes.sum() > static_cast<double>(kFewestToSay) &&
           left < kMinority * (brakes * calc_left(without).array()).square().sum();
  }

  double find_most() const { return effort_.cwiseAbs().maxCoeff(); }

 private:
  Eigen::MatrixXd make_columns(double limit) const {
    Eigen::MatrixXd columns = columns_;
    columns.rightCols(1) = calc_absent_(effort_, limit);
    return columns;
  }

  // Least squares of the missing torque. A rotor below zero would take the model's own inertia away: it is then left
  // out. With nothing but the effort that is there, a limit near zero would explain all.
  Eigen::VectorXd solve(Eigen::MatrixXd columns) const {
    const Eigen::VectorXd x = columns.colPivHouseholderQr().solve(missing_);
    if (x[kRotor] >= 0.0) return x;
    columns.col(kRotor).setZero();
    return columns.colPivHouseholderQr().solve(missing_);
  }

  Eigen::VectorXd calc_left(const AtLimit& at) const {
    const Eigen::MatrixXd columns = make_columns(at.limit);
    return missing_ - columns * solve(columns);
  }

  // The best of kTried limits from `begin` on.
  AtLimit scan(double begin, double step, AtLimit best) const {
    for (int i = 0; i < kTried; ++i) {
      const double limit = begin + i * step;
      const AtLimit at = limit > 0.0 ? try_limit(limit) : best;
      if (at.left < best.left) best = at;
    }
    return best;
  }

  const CalcAbsent calc_absent_;
  const bool any_unit_;
  const Eigen::VectorXd effort_;
  Eigen::VectorXd missing_;  // effort - tau, or - tau where the unit is not known
  Eigen::MatrixXd columns_;  // friction, rotor, constant; friction of the load; - effort of any unit; absent effort
};

// The width of a dead zone; 0: none.
AtLimit find_dead_zone(const UnitRows& rows, Unit unit) {
  const Search search(rows, &calc_within, unit);
  if (!search.is_told()) return {};
  // Nothing would move a drive that gives nothing most of the time: its own rotor takes such efforts.
  const AtLimit without = search.try_limit(0.0), best = search.find(0.0, kHalf, without);
  return search.explains_braking(best, without) ? best : AtLimit{};
}

}  // namespace

std::vector<double> find_limits(const TorqueData& data, int joint) {
  // A servo's law is no log of what was asked for: its limit is stated.
  if (data.source[static_cast<size_t>(joint)] != EffortSource::kRecorded) return {};
  const Search search(collect_efforts(data, joint), &calc_beyond, Unit::kTorque);
  if (!search.is_told()) return {};
  const AtLimit best = search.find(kHalf, 1.0, search.try_limit(search.find_most()));
  // A drive that gives no more than its joint's friction, which varies by a fifth, does not move the joint: friction
  // that holds it for most of the time takes as much as the drive gives.
  return best.dry < kMostly * best.limit ? std::vector<double>{best.limit} : std::vector<double>{};
}

std::vector<double> find_dead_zones(const TorqueData& data, int joint) {
  const AtLimit best = find_dead_zone(collect_efforts(data, joint), Unit::kTorque);
  return best.limit > 0.0 ? std::vector<double>{best.limit} : std::vector<double>{};
}

std::optional<double> find_unit_beside_dead_zone(const UnitRows& rows) {
  const AtLimit best = find_dead_zone(rows, Unit::kAny);
  return best.limit > 0.0 && best.scale > 0.0 ? std::optional<double>(best.scale) : std::nullopt;
}

}  // namespace hrp::diagnosis
