// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/servo_law.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

constexpr double kLongest = 0.1;    // [s] that a drive's commands are late at most
constexpr double kScan = 0.001;     // [s]
constexpr double kBetter = 3.0;     // times less that the law misses with the delay
constexpr double kFollows = 0.3;    // of the effort's spread that the law misses at most: else it is no such servo

bool has_all(const Experiment& e, size_t j) {
  return std::all_of(e.recordings.begin(), e.recordings.end(), [&](const Recording& r) {
    const JointColumns& c = r.joints[j];
    return !c.command.empty() && c.has(Quantity::kPosition) && c.has(Quantity::kVelocity) && c.has(Quantity::kEffort);
  });
}

// Mean square of what the law misses when commands are `delay` late.
double calc_missed(const Experiment& e, size_t j, const JointLaws& laws, double delay, bool train) {
  double sum = 0.0, n = 0.0;
  for (const Recording& r : e.recordings) {
    if (r.spec.train != train) continue;
    const JointColumns& c = r.joints[j];
    for (size_t k = 0; k < r.size(); ++k) {
      if (r.time[k] < r.time.front() + kLongest) continue;
      double given = 0.0, rate = 0.0;
      read_command(r.time, c, r.time[k] - delay, k, &given, &rate);
      const double law = calc_servo_effort(laws, given - c.signal[0][k], rate - c.signal[1][k], 0.0);
      const double missed = c.signal[2][k] - std::clamp(law, -laws.effort_limit, laws.effort_limit);
      if (std::isfinite(missed)) sum += missed * missed, n += 1.0;
    }
  }
  return n > 0.0 ? sum / n : 0.0;
}

double calc_spread(const Experiment& e, size_t j) {
  double sum = 0.0, square = 0.0, n = 0.0;
  for (const Recording& r : e.recordings) {
    for (double y : r.joints[j].signal[2]) {
      if (std::isfinite(y)) sum += y, square += y * y, n += 1.0;
    }
  }
  return n > 1.0 ? std::sqrt(std::max(0.0, square / n - sum * sum / n / n)) : 0.0;
}

}  // namespace

std::vector<ServoDelay> find_servo_delays(const Experiment& e) {
  std::vector<ServoDelay> list;
  if (e.scenario.drive != "servo") return list;
  const Plant plant = make_plant(e, {});
  const bool held = std::any_of(e.recordings.begin(), e.recordings.end(), [](const Recording& r) { return !r.spec.train; });
  for (size_t j = 0; j < plant.laws.size(); ++j) {
    if (!has_all(e, j) || !(plant.laws[j].kp > 0.0)) continue;
    const auto missed = [&](double delay) { return calc_missed(e, j, plant.laws[j], delay, true); };
    const double none = missed(0.0);
    double best = none, delay = 0.0;
    for (double d = kScan; d <= kLongest; d += kScan) {
      const double m = missed(d);
      if (m < best) best = m, delay = d;
    }
    if (!(none > kBetter * kBetter * best) || std::sqrt(best) > kFollows * calc_spread(e, j)) continue;
    // The vertex of the parabola through the best delay and its neighbours.
    const double left = missed(delay - kScan), right = missed(delay + kScan), bend = left - 2.0 * best + right;
    if (bend > 0.0) delay += std::clamp(0.5 * kScan * (left - right) / bend, -kScan, kScan);
    ServoDelay found{static_cast<int>(j), delay, 0.5 * std::min(kScan, e.sample_time), 0.0, 0.0};
    found.before = std::sqrt(calc_missed(e, j, plant.laws[j], 0.0, !held));
    found.after = std::sqrt(calc_missed(e, j, plant.laws[j], delay, !held));
    list.push_back(found);
  }
  return list;
}

}  // namespace hrp::diagnosis
