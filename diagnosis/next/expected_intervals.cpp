// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/expected_intervals.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/torque/samples.h"
#include "diagnosis/next/motions.h"
#include "diagnosis/next/proposal_parts.h"

namespace hrp::diagnosis {
namespace {

constexpr double kForEver = 1e3;  // times that a motion is repeated, until the recordings before it no longer count
constexpr double kUnknown = 1e6;  // standard deviation of a parameter that nothing shows

// Slots of the columns of list_torque_samples().
std::vector<long> list_slots(const OpenTerms& terms, size_t i) {
  const TorqueSide& best = terms.best;
  std::vector<long> slots;
  const auto add = [&](const Term& term, long first) {
    for (long c = 0; c < term.columns(); ++c) slots.push_back(first + c);
  };
  for (size_t k = 0; k < best.model.own[i].size(); ++k)
    add(terms.design.joints[i].terms[best.model.own[i][k]], best.slots.own[i][k]);
  for (size_t k = 0; k < best.model.whole.size(); ++k)
    add(terms.design.whole[best.model.whole[k]], best.slots.whole[k]);
  return slots;
}

long count_whole(const OpenTerms& terms) {
  long count = 0;
  for (size_t t : terms.best.model.whole) count += terms.design.whole[t].columns();
  return count;
}

// Sums of samples of this length [s] each.
ConsideredSums sum(const Eigen::MatrixXd& x, const Eigen::VectorXd& effort, const Eigen::VectorXd& rate, double time) {
  ConsideredSums sums = sum_considered(x, effort, rate);
  sums.xx *= time;
  sums.moved *= time;
  return sums;
}

Eigen::VectorXd calc_rate(const Eigen::VectorXd& y, double step) {
  const std::vector<double> rate = calc_rates({y.data(), y.data() + y.size()}, step);
  return Eigen::Map<const Eigen::VectorXd>(rate.data(), y.size());
}

// What joints have been through in the recordings for training.
Ranges list_seen(const Experiment& experiment) {
  Ranges ranges(static_cast<size_t>(experiment.num_joints()), {1e300, -1e300});
  for (const Recording& r : experiment.recordings) {
    for (size_t j = 0; j < r.joints.size() && r.spec.train; ++j) widen(r.joints[j].signal[0], &ranges[j]);
  }
  return ranges;
}

double calc_range(const Ranges& ranges, int joint) {
  const auto& [low, high] = ranges[static_cast<size_t>(joint)];
  return std::max(0.0, high - low);
}

Eigen::VectorXd calc_std(const Eigen::MatrixXd& known) {
  return calc_expected_std(known, Eigen::VectorXd::Constant(known.rows(), kUnknown));
}

}  // namespace

void widen(const std::vector<double>& positions, std::pair<double, double>* range) {
  for (double q : positions) {
    if (std::isfinite(q)) {
      range->first = std::min(range->first, q);
      range->second = std::max(range->second, q);
    }
  }
}

ExpectedIntervals::ExpectedIntervals(const Experiment& experiment, const OpenTerms& terms, const TorqueRows& rows,
                                     const Limits& limits)
    : e_(experiment), terms_(terms), rows_(rows), known_(rows.calc_known(terms.best)) {
  for (size_t i = 0; i < terms.design.joints.size(); ++i) {
    slots_.push_back(list_slots(terms, i));
    const TorqueSamples all = list_torque_samples(terms.design, terms.best.model, i);
    const long width = static_cast<long>(slots_.back().size());
    if (all.x.rows() > 0 && width > 0)
      sums_.push_back(sum(all.x, all.effort, all.effort_rate, rows.calc_sample_time(i)));
    else
      sums_.push_back({Eigen::MatrixXd::Zero(width, width), Eigen::MatrixXd::Zero(width, 2)});
  }
  nothing_ = {Eigen::MatrixXd::Zero(known_.rows(), known_.cols()), list_seen(e_), sums_};
  for (ConsideredSums& sums : nothing_.considered) {
    sums.xx.setZero();
    sums.moved.setZero();
  }
  if (terms_.values.empty()) return;
  before_ = calc_std(known_);
  now_ = least_ = list_considered(nothing_.considered, 1.0);
  masses_ = kNinetyFive * calc_unsure_mass_std(terms.design, terms.best.model, terms.best.fit);
  for (const OpenValue& v : terms.values) {
    const bool own = terms.best.slots.whole.empty() || v.slot < terms.best.slots.whole[0];
    if (!own || is_loss(get_effect(v.effect))) masses_[v.slot] = 0.0;
  }
  widest_ = nothing_.ranges;
  for (size_t j = 0; j < widest_.size(); ++j) widen({limits.joints[j].lower, limits.joints[j].upper}, &widest_[j]);
}

std::vector<ConsideredSums> ExpectedIntervals::sum_along(const MotionRows& motion) const {
  std::vector<ConsideredSums> list;
  for (size_t i = 0; i < slots_.size(); ++i) {
    const std::vector<long> columns = rows_.list_slots_of(terms_.best, i);
    Eigen::MatrixXd x(motion.x[i].rows(), static_cast<long>(slots_[i].size()));
    for (size_t c = 0; c < slots_[i].size(); ++c) {
      const long column = std::find(columns.begin(), columns.end(), slots_[i][c]) - columns.begin();
      x.col(static_cast<long>(c)) = motion.x[i].col(column);
    }
    const Eigen::VectorXd effort = rows_.predict(motion, terms_.best, i);
    list.push_back(sum(x, effort, calc_rate(effort, motion.step), motion.step));
  }
  return list;
}

std::vector<double> ExpectedIntervals::list_considered(const std::vector<ConsideredSums>& gained, double times) const {
  std::vector<double> widths(static_cast<size_t>(known_.rows()), 0.0);
  for (size_t i = 0; i < slots_.size(); ++i) {
    const ConsideredSums all{sums_[i].xx + times * gained[i].xx, sums_[i].moved + times * gained[i].moved};
    if (all.xx.size() == 0) continue;
    const Eigen::VectorXd variance = calc_considered_variance(all, e_.sample_time, kKnown);
    const size_t own = slots_[i].size() - static_cast<size_t>(count_whole(terms_));
    for (size_t c = 0; c < own; ++c)
      widths[static_cast<size_t>(slots_[i][c])] = kNinetyFive * std::sqrt(variance[static_cast<long>(c)]);
  }
  return widths;
}

void ExpectedIntervals::allow(const std::vector<ConsideredSums>& along) {
  const std::vector<double> reached = list_considered(along, kForEver);
  for (size_t slot = 0; slot < least_.size(); ++slot) least_[slot] = std::min(least_[slot], reached[slot]);
}

std::vector<ExpectedInterval> ExpectedIntervals::list(const Gained& gained) const {
  std::vector<ExpectedInterval> list;
  if (terms_.values.empty()) return list;
  const Eigen::VectorXd after = calc_std(known_ + gained.fisher);
  const std::vector<double> then = list_considered(gained.considered, 1.0);
  for (const OpenValue& v : terms_.values) {
    const size_t slot = static_cast<size_t>(v.slot);
    const auto calc_unseen = [&](const Ranges& ranges) {
      return v.dry_joint < 0 ? 0.0 : kNinetyFive * calc_unseen_std(v.value, calc_range(ranges, v.dry_joint));
    };
    const double width = calc_expected_width(
        v.half_width, {kNinetyFive * before_[v.slot], calc_unseen(nothing_.ranges), now_[slot], masses_[v.slot]},
        {kNinetyFive * after[v.slot], calc_unseen(gained.ranges), then[slot], masses_[v.slot]});
    // No report states less than the agreement of two implementations of a law.
    const double floor = std::min(v.half_width, kNinetyFive * kAgreement * std::abs(v.value));
    const double after_it = std::max(floor, width),
                 stays = std::hypot(std::hypot(calc_unseen(widest_), masses_[v.slot]), least_[slot]);
    list.push_back(
        {v.label, v.parameter, v.unit, v.value, v.half_width, after_it, std::min(after_it, std::max(floor, stays))});
  }
  return list;
}

}  // namespace hrp::diagnosis
