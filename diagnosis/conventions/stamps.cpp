// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/stamps.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "diagnosis/data/gaps.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

constexpr double kResolution = 1e-6;  // [rad or m] no command is known better: digits of a log, curvature between rows
constexpr size_t kAround = 4;         // rows on each side of a step, for the mean speed
constexpr size_t kCluster = 16;       // steps with correlated errors: an encoder's step stays for several rows

// What the commands tell about each step between rows.
struct Told {
  std::vector<double> late;    // [s] stamped time of the step minus the true one
  std::vector<double> weight;  // [1/s^2] inverse variance; 0: nothing moves
  double apart = 0.0;          // sum of squared differences [rad^2] between commands and stamps
  double left = 0.0;           // the same after one correction for all joints
};

bool tells_time(const JointColumns& joint) {
  return !joint.command.empty() && !joint.command_rate.empty() && !joint.separate_rate;
}

Told read_commands(const Recording& r) {
  const size_t steps = r.size() - 1;
  // Longer steps lack rows, and the commands between them are unknown.
  const double longest = kClearlyMore * find_period(r.time);
  Told told{std::vector<double>(steps, 0.0), std::vector<double>(steps, 0.0), 0.0, 0.0};
  double moving = 0.0;
  for (size_t k = 0; k < steps; ++k) {
    const double dt = r.time[k + 1] - r.time[k];
    double rates = 0.0, product = 0.0, square = 0.0;
    for (const JointColumns& joint : r.joints) {
      if (!tells_time(joint) || dt > longest) continue;
      const double rate = 0.5 * (joint.command_rate[k] + joint.command_rate[k + 1]);
      const double apart = rate * dt - (joint.command[k + 1] - joint.command[k]);
      rates += rate * rate;
      product += rate * apart;
      square += apart * apart;
    }
    if (!(rates > 0.0)) continue;
    told.late[k] = product / rates;
    told.weight[k] = rates;
    told.apart += square;
    told.left += std::max(0.0, square - product * product / rates);
    moving += 1.0;
  }
  const double deviation = std::max(kResolution, std::sqrt(told.left / std::max(1.0, moving)));
  for (double& w : told.weight) w /= deviation * deviation;
  return told;
}

// [s] Standard deviation of one stamp's error: the error of a step has twice its variance.
double find_deviation(const Told& told, double shortest) {
  double sum = 0.0, n = 0.0;
  for (size_t k = 0; k < told.late.size(); ++k) {
    if (told.weight[k] * shortest * shortest < 1.0) continue;
    sum += told.late[k] * told.late[k];
    n += 1.0;
  }
  return n > 0.0 ? std::sqrt(0.5 * sum / n) : 0.0;
}

// Most probable errors of the stamps [s]: they are independent with the standard deviation `deviation`, and their
// differences are what the commands tell. Tridiagonal normal equations.
std::vector<double> solve_errors(const Told& told, double deviation) {
  const size_t n = told.late.size() + 1;
  std::vector<double> diagonal(n, 1.0 / (deviation * deviation)), errors(n, 0.0);
  for (size_t k = 0; k + 1 < n; ++k) {
    const double w = told.weight[k];
    diagonal[k] += w;
    diagonal[k + 1] += w;
    errors[k] -= w * told.late[k];
    errors[k + 1] += w * told.late[k];
  }
  for (size_t k = 1; k < n; ++k) {
    const double factor = told.weight[k - 1] / diagonal[k - 1];
    diagonal[k] -= factor * told.weight[k - 1];
    errors[k] += factor * errors[k - 1];
  }
  errors[n - 1] /= diagonal[n - 1];
  for (size_t k = n - 1; k-- > 0;) errors[k] = (errors[k] + told.weight[k] * errors[k + 1]) / diagonal[k];
  return errors;
}

// Regression of measured steps on the steps that the corrections predict.
struct Confirmation {
  double squares = 0.0, product = 0.0, scatter = 0.0;
};

// Sums of one joint: [rad^2], and `scatter` [rad^4] from clusters of steps at the slope `slope`.
Confirmation compare(const Recording& r, const std::vector<double>& q, const std::vector<double>& errors,
                     double slope) {
  Confirmation c;
  double score = 0.0;
  for (size_t k = kAround; k + kAround + 1 < r.size(); ++k) {
    const size_t first = k - kAround, last = k + kAround + 1;
    const double dt = r.time[k + 1] - r.time[k], around = r.time[last] - r.time[first];
    const double speed = (q[last] - q[first]) / around;
    const double told = -speed * (errors[k + 1] - errors[k] - (errors[last] - errors[first]) * dt / around);
    const double moved = q[k + 1] - q[k] - speed * dt;
    if (std::isfinite(told) && std::isfinite(moved)) {
      c.squares += told * told;
      c.product += told * moved;
      score += told * (moved - slope * told);
    }
    if (k % kCluster != 0) continue;
    c.scatter += score * score;
    score = 0.0;
  }
  return c;
}

// True if measured positions follow the corrected stamps: they tell a slope of one, and not zero.
bool is_confirmed(const Recording& r, const std::vector<double>& errors) {
  double weight = 0.0, sum = 0.0;
  for (const JointColumns& joint : r.joints) {
    const std::vector<double>& q = joint.signal[static_cast<size_t>(Quantity::kPosition)];
    if (q.size() != r.size()) continue;
    const Confirmation first = compare(r, q, errors, 0.0);
    if (!(first.squares > 0.0)) continue;
    const double slope = first.product / first.squares, scatter = compare(r, q, errors, slope).scatter;
    if (!(scatter > 0.0)) continue;
    const double inverse = first.squares * first.squares / scatter;  // of the slope's variance
    weight += inverse;
    sum += inverse * slope;
  }
  if (!(weight > 0.0)) return false;
  const double slope = sum / weight, margin = kUnlikely / std::sqrt(weight);
  return slope > margin && std::abs(slope - 1.0) < std::max(kDetail, margin) && margin < kHalf;
}

bool is_increasing(const std::vector<double>& time) {
  return std::adjacent_find(time.begin(), time.end(), [](double a, double b) { return !(a < b); }) == time.end();
}

}  // namespace

std::vector<double> find_stamp_errors(const Recording& r) {
  if (r.size() < 4 * kCluster) return {};
  const double negligible = kTrace * find_period(r.time);
  const Told told = read_commands(r);
  const double deviation = find_deviation(told, negligible);
  if (deviation < negligible || told.left > kDetail * told.apart) return {};
  std::vector<double> errors = solve_errors(told, deviation), time = r.time;
  for (size_t k = 0; k < time.size(); ++k) time[k] -= errors[k];
  return is_increasing(time) && is_confirmed(r, errors) ? errors : std::vector<double>{};
}

Experiment correct_stamps(Experiment e) {
  for (Recording& r : e.recordings) {
    const std::vector<double> errors = find_stamp_errors(r);
    if (errors.empty()) continue;
    double sum = 0.0;
    for (size_t k = 0; k < errors.size(); ++k) {
      r.time[k] -= errors[k];
      sum += errors[k] * errors[k];
    }
    e.warnings.push_back(r.spec.name + ": time stamps of single rows err by " +
                         number(1e3 * std::sqrt(sum / static_cast<double>(errors.size())), 2) +
                         " ms (rms), as all commands and the measured positions tell; corrected");
  }
  return e;
}

}  // namespace hrp::diagnosis
