// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/velocity_log.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/rounds.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/measurement/torque/term_rows.h"

namespace hrp::diagnosis {
namespace {

constexpr double kCutoff = 8.0;         // [Hz] cutoff of both columns
constexpr double kTrim = 0.3;           // [s] left out at both ends, where derivatives are one-sided
constexpr double kLeastFilter = 0.004;  // [s] smallest delay of a velocity; differences and filters cause as much

// Columns of v = scale (r - late r' + c r'') + bias, with r the rate of the position: the first terms of any filter or
// delay. A filter that attenuates fast motion has its c, so it does not look like a scale.
enum Column : int { kRate, kLate, kDamped, kConstant, kColumns };
const Columns kAll = {kRate, kLate, kDamped, kConstant}, kUndamped = {kRate, kLate, kConstant};

// The rate and its derivatives along one recording, on a uniform grid.
struct Motion {
  const Recording* recording;
  double step;                                              // [s]
  Eigen::Matrix<double, Eigen::Dynamic, kColumns> columns;  // by sample
  long count_trimmed(double late) const { return std::lround((kTrim + std::abs(late)) / step); }
  long count(double late) const { return std::max(0L, columns.rows() - 2 * count_trimmed(late)); }
};

Eigen::VectorXd read(const Motion& motion, const std::vector<double>& series, double shift) {
  const Recording& r = *motion.recording;
  return low_pass(resample(r.time, series, r.time[0] + shift, motion.step, motion.columns.rows()), motion.step,
                  kCutoff);
}

// Training recordings with both columns.
std::vector<Motion> list_motions(const Experiment& e, size_t joint) {
  std::vector<Motion> list;
  for (const Recording& r : e.recordings) {
    const JointColumns& c = r.joints[joint];
    if (!r.spec.train || !c.has(Quantity::kPosition) || !c.has(Quantity::kVelocity) || r.duration() < kShortestPart)
      continue;
    Motion& motion = list.emplace_back(Motion{&r, std::max(1e-3, e.sample_time), {}});
    motion.columns.resize(static_cast<long>(r.duration() / motion.step) + 1, kColumns);
    Eigen::VectorXd derivative = read(motion, c.signal[static_cast<size_t>(Quantity::kPosition)], 0.0);
    for (int column = kRate; column < kConstant; ++column) {
      derivative = differentiate(derivative, motion.step);
      motion.columns.col(column) = derivative;
    }
    motion.columns.col(kConstant).setOnes();
  }
  return list;
}

// Sums over stretches of all motions, with velocities read `late` [s] after the positions. What a filter begins with
// shows for as long as `begun` [s].
std::vector<Gram> add_stretches(const std::vector<Motion>& motions, size_t joint, double late, double begun = 0.0) {
  long samples = 0;
  for (const Motion& motion : motions) samples += motion.count(std::abs(late) + begun);
  std::vector<Gram> folds(kFolds, Gram(kColumns));
  long k = 0;
  for (const Motion& motion : motions) {
    const Eigen::VectorXd velocity =
        read(motion, motion.recording->joints[joint].signal[static_cast<size_t>(Quantity::kVelocity)], late);
    const long trim = motion.count_trimmed(std::abs(late) + begun);
    for (long row = trim; row < trim + motion.count(std::abs(late) + begun); ++row, ++k)
      folds[static_cast<size_t>(k * kFolds / samples)].add_row(motion.columns.row(row).transpose(), velocity[row]);
  }
  return folds;
}

// The velocity by the sums of these columns: the rate, its change by a delay, and a constant last. `late` is how much
// longer than in the columns the delay is. Neutral if the velocity does not follow.
VelocityReading read_columns(const std::vector<Gram>& folds, const Columns& columns, double sample_time) {
  VelocityReading out;
  const Gram total = sum(folds, kColumns);
  if (!(total.c > 0.0)) return out;
  const Eigen::VectorXd theta = solve(total, columns);
  const double left = calc_rest(total, columns, theta) / total.c, spread = std::sqrt(total.c / total.n);
  if (!(left < kDetail * kDetail) || !(theta[0] > 0.0)) return out;
  const Eigen::VectorXd std = calc_covariance(folds, total, columns, theta).diagonal().cwiseMax(0.0).cwiseSqrt();
  const long last = theta.size() - 1;
  // Noise of the rate reduces the slope by at most the relative squared residual.
  out.scale = theta[0];
  out.scale_std = std::hypot(std[0], left, kAgreement);
  out.ratio = out.scale;
  out.ratio_std = out.scale_std;
  out.late = -theta[1] / theta[0];
  out.late_std = std::hypot(std[1] / theta[0], kMinor * sample_time);
  out.bias = theta[last];
  out.bias_std = std::hypot(std[last], kAgreement * spread);
  if (std::abs(out.bias) < std::max(kKnown * spread, kSignificantInJoint * out.bias_std)) out.bias = 0.0;
  out.after = std::sqrt(left) * spread;
  return out;
}

// A motion of one frequency does not tell a scale from the damping of a filter: of both readings the one that claims
// less.
void take_smaller_scale(const VelocityReading& undamped, VelocityReading* out) {
  if (undamped.ratio == 0.0 || std::abs(undamped.scale - 1.0) > std::abs(out->scale - 1.0)) return;
  out->scale = out->ratio = undamped.scale;
  out->scale_std = out->ratio_std = undamped.scale_std;
}

// A velocity that is late by up to kLongest. `as_logged`: the sums without a delay.
VelocityReading read_delayed(const std::vector<Motion>& motions, size_t joint, const std::vector<Gram>& as_logged,
                             double sample_time) {
  VelocityReading out;
  double late = 0.0, step = 0.0;
  // The damping of a mean over a time leaves half of the way at each step.
  for (int round = 0; round < kFewRounds || (round < kHalvings && std::abs(step) > kMinor * sample_time); ++round) {
    const std::vector<Gram> folds = round == 0 ? as_logged : add_stretches(motions, joint, late);
    out = read_columns(folds, kAll, sample_time);
    step = out.late;
    late += step;
    out.late = late;
    if (out.ratio == 0.0 || !(std::abs(late) < kLongest)) return {};
    take_smaller_scale(read_columns(folds, kUndamped, sample_time), &out);
  }
  return out;
}

// The rate behind a filter 1 / (T s + 1); exact for a rate that is linear between samples.
Eigen::VectorXd pass_filter(const Eigen::VectorXd& rate, double step, double time) {
  Eigen::VectorXd out = rate;
  const double keep = std::exp(-step / time), slope = time * (1.0 - keep) / step;
  for (long k = 1; k < rate.size(); ++k)
    out[k] = keep * out[k - 1] + (slope - keep) * rate[k - 1] + (1.0 - slope) * rate[k];
  return out;
}

// A velocity that is later than any delay came through a slow filter. By the rate behind a filter of T, and its
// derivative with respect to T: that of the rate behind two of them. `late` is the time constant.
VelocityReading read_filtered(const std::vector<Motion>& motions, size_t joint, double sample_time) {
  VelocityReading out;
  double time = kLongest;
  for (int round = 0; round < kHalvings; ++round) {
    std::vector<Motion> filtered = motions;
    for (Motion& m : filtered) {
      m.columns.col(kRate) = pass_filter(m.columns.col(kRate), m.step, time);
      m.columns.col(kLate) = pass_filter(pass_filter(m.columns.col(kLate), m.step, time), m.step, time);
    }
    out = read_columns(add_stretches(filtered, joint, 0.0, kShortestPart * kPart), kUndamped, sample_time);
    time += out.late;
    out.late = time;
    if (out.ratio == 0.0 || !(time > kHalf * kLongest)) return {};
  }
  // A filter that runs once a sample holds the rate before it, or the new one: either is half a sample off.
  out.late_std = std::hypot(out.late_std, kHalf * sample_time);
  return out.late > kLongest ? out : VelocityReading{};
}

VelocityReading read_velocity(const Experiment& e, size_t joint) {
  const std::vector<Motion> motions = list_motions(e, joint);
  const std::vector<Gram> as_logged = add_stretches(motions, joint, 0.0);
  VelocityReading out = read_delayed(motions, joint, as_logged, e.sample_time);
  if (out.ratio == 0.0) out = read_filtered(motions, joint, e.sample_time);
  if (out.ratio == 0.0) return {};
  const Gram total = sum(as_logged, kColumns);
  out.before = std::sqrt(calc_rest(total, {0}, Eigen::VectorXd::Ones(1)) / total.n);
  if (std::abs(out.scale - 1.0) < std::max(kMaterialFactor, kSignificantInJoint * out.scale_std)) out.scale = 1.0;
  const double least =
      std::max({e.sample_time, kSignificantInJoint * out.late_std, out.late > 0.0 ? kLeastFilter : 0.0});
  if (std::abs(out.late) < least) out.late = 0.0;
  return out;
}

}  // namespace

std::vector<VelocityReading> find_velocity_readings(const Experiment& e) {
  std::vector<VelocityReading> list;
  for (size_t j = 0; j < static_cast<size_t>(e.num_joints()); ++j) list.push_back(read_velocity(e, j));
  return list;
}

bool may_be_clock(const std::vector<VelocityReading>& readings, const VelocityReading& scaled) {
  return std::all_of(readings.begin(), readings.end(), [&](const VelocityReading& r) {
    return r.ratio == 0.0 ||
           std::abs(r.ratio - scaled.scale) < kSignificantInJoint * std::hypot(r.ratio_std, scaled.scale_std);
  });
}

Experiment correct_joint_logs(const Experiment& e, const std::vector<VelocityReading>& readings) {
  Experiment out = e;
  for (Recording& r : out.recordings) {
    for (size_t j = 0; j < readings.size(); ++j) {
      const VelocityReading& log = readings[j];
      JointColumns& c = r.joints[j];
      if (!c.has(Quantity::kPosition) || !c.has(Quantity::kVelocity)) continue;
      if (log.late > kLongest) {  // of a filter, which leaves nothing sharp: the position's rate is better
        c.signal[1].clear();
        continue;
      }
      for (double& v : c.signal[1]) v = (v - log.bias) / log.scale;
      if (log.is_late()) move_series(r.time, log.late, &c.signal[1]);
      if (log.is_position_late()) move_series(r.time, -log.late, &c.signal[0]);
    }
  }
  return out;
}

}  // namespace hrp::diagnosis
