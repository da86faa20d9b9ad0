// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/velocity_log.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/measurement/term_rows.h"

namespace hrp::diagnosis {
namespace {

constexpr double kCutoff = 8.0;         // [Hz] of the motion that both columns are compared in
constexpr double kTrim = 0.3;           // [s] at both ends, where derivatives are one-sided
constexpr double kShortest = 1.0;       // [s]
constexpr double kFollows = 0.1;        // of the velocity's spread that its rate misses at most: a rate of noise tells nothing
constexpr int kStretches = 16;          // of all samples
constexpr double kCertain = 4.0;        // standard deviations of a fault from none
constexpr double kLeastFilter = 0.004;  // [s] that a velocity is late at least: differences and filters take as much
constexpr double kMostLate = 0.1;       // [s]
constexpr double kExact = 1e-3;         // to which differences over samples agree with a rate: of a scale
constexpr double kExactTime = 0.05;     // the same of a delay, over the sampling time
constexpr int kRounds = 3;              // of linear steps towards the delay

// Columns of v = scale (r - late r' + c r''), r the rate of the position: the first terms of any filter or delay. A filter
// that takes away from fast motion has its c, and is no scale.
constexpr int kColumns = 3;
const Columns kAll = {0, 1, 2};
struct Compared {
  Eigen::Matrix<double, Eigen::Dynamic, kColumns> rate;  // by sample
  Eigen::VectorXd velocity;
};

// One recording, its velocity read `late` [s] after the position.
Compared compare(const Recording& r, size_t joint, double period, double late) {
  const JointColumns& c = r.joints[joint];
  if (!c.has(Quantity::kPosition) || !c.has(Quantity::kVelocity) || r.duration() < kShortest) return {};
  const double step = std::max(1e-3, period);
  const long rows = static_cast<long>(r.duration() / step) + 1, trim = std::lround((kTrim + std::abs(late)) / step);
  if (rows <= 2 * trim) return {};
  const auto read = [&](int quantity, double shift) {
    return low_pass(resample(r.time, c.signal[static_cast<size_t>(quantity)], r.time[0] + shift, step, rows), step, kCutoff);
  };
  Eigen::VectorXd derivative = read(0, 0.0);
  Compared out;
  out.rate.resize(rows - 2 * trim, kColumns);
  for (int column = 0; column < kColumns; ++column) {
    derivative = differentiate(derivative, step);
    out.rate.col(column) = derivative.segment(trim, rows - 2 * trim);
  }
  out.velocity = read(1, late).segment(trim, rows - 2 * trim);
  return out;
}

std::vector<Gram> add_stretches(const Experiment& e, size_t joint, double late) {
  std::vector<Compared> parts;
  long samples = 0;
  for (const Recording& r : e.recordings) {
    if (r.spec.train) parts.push_back(compare(r, joint, e.sample_time, late)), samples += parts.back().velocity.size();
  }
  std::vector<Gram> folds(kStretches, Gram(kColumns));
  long k = 0;
  for (const Compared& part : parts) {
    for (long row = 0; row < part.velocity.size(); ++row, ++k)
      folds[static_cast<size_t>(k * kStretches / samples)].add_row(part.rate.row(row).transpose(), part.velocity[row]);
  }
  return folds;
}

VelocityReading read_velocity(const Experiment& e, size_t joint) {
  VelocityReading out;
  double late = 0.0, before = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Gram> folds = add_stretches(e, joint, late);
    const Gram total = sum(folds, kColumns);
    if (!(total.c > 0.0)) return {};
    if (round == 0) before = calc_rest(total, {0}, Eigen::VectorXd::Ones(1)) / total.n;
    const Eigen::VectorXd theta = solve(total, kAll);
    const double left = calc_rest(total, kAll, theta) / total.c;
    if (!(left < kFollows * kFollows) || !(theta[0] > 0.0)) return {};
    late -= theta[1] / theta[0];
    if (!(std::abs(late) < kMostLate)) return {};
    const Eigen::VectorXd std = calc_covariance(folds, total, kAll, theta).diagonal().cwiseMax(0.0).cwiseSqrt();
    // Noise of the rate flattens the line by no more than the share of squares that is left.
    out.scale = theta[0], out.scale_std = std::hypot(std[0], left, kExact);
    out.ratio = out.scale, out.ratio_std = out.scale_std;
    out.late = late, out.late_std = std::hypot(std[1] / theta[0], kExactTime * e.sample_time);
    out.before = std::sqrt(before), out.after = std::sqrt(left * total.c / total.n);
  }
  if (std::abs(out.scale - 1.0) < std::max(kMaterialFactor, kCertain * out.scale_std)) out.scale = 1.0;
  const double least = std::max({e.sample_time, kCertain * out.late_std, out.late > 0.0 ? kLeastFilter : 0.0});
  if (std::abs(out.late) < least) out.late = 0.0;
  return out;
}

// A series at the recording's stamps, read `late` [s] after them.
void move_series(const std::vector<double>& time, double late, std::vector<double>* series) {
  const std::vector<double> logged = *series;
  for (size_t k = 0; k < time.size(); ++k) (*series)[k] = interpolate(time, logged, time[k] + late, k);
}

}  // namespace

std::vector<VelocityReading> find_velocity_readings(const Experiment& e) {
  std::vector<VelocityReading> list;
  for (size_t j = 0; j < static_cast<size_t>(e.num_joints()); ++j) list.push_back(read_velocity(e, j));
  return list;
}

bool may_be_clock(const std::vector<VelocityReading>& readings, const VelocityReading& scaled) {
  return std::all_of(readings.begin(), readings.end(), [&](const VelocityReading& r) {
    return r.ratio == 0.0 || std::abs(r.ratio - scaled.scale) < kCertain * std::hypot(r.ratio_std, scaled.scale_std);
  });
}

Experiment correct_joint_logs(const Experiment& e, const std::vector<VelocityReading>& readings) {
  Experiment out = e;
  for (Recording& r : out.recordings) {
    for (size_t j = 0; j < readings.size(); ++j) {
      const VelocityReading& log = readings[j];
      JointColumns& c = r.joints[j];
      if (!c.has(Quantity::kPosition) || !c.has(Quantity::kVelocity)) continue;
      for (double& v : c.signal[1]) v /= log.scale;
      if (log.is_late()) move_series(r.time, log.late, &c.signal[1]);
      if (log.is_position_late()) move_series(r.time, -log.late, &c.signal[0]);
    }
  }
  return out;
}

}  // namespace hrp::diagnosis
