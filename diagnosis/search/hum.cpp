// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/hum.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {
namespace {

constexpr double kFarOff = 1.0, kOff = 0.1;  // mean velocity off the position's rate, in standard deviations

// Mean rate of the recorded position [rad/s].
double calc_mean_rate(const Recording& recording, const JointColumns& joint) {
  return (joint.signal[0].back() - joint.signal[0].front()) / recording.duration();
}

struct Readings {
  double off = 0.0;      // mean velocity minus mean rate of the position, in standard deviations of the velocity
  double limited = 0.0;  // share of the samples at the effort limit
};

Readings read_joint(const Recording& recording, const JointColumns& joint, double limit) {
  if (!joint.has(Quantity::kVelocity) || !joint.has(Quantity::kEffort) || !std::isfinite(limit)) return {};
  double n = 0.0, sum = 0.0, squares = 0.0, limited = 0.0;
  for (size_t k = 0; k < recording.size(); ++k) {
    const double v = joint.signal[1][k], u = joint.signal[2][k];
    if (!std::isfinite(v) || !std::isfinite(u)) continue;
    n += 1.0;
    sum += v;
    squares += v * v;
    limited += std::abs(u) > (1.0 - kKnown) * limit ? 1.0 : 0.0;
  }
  if (n == 0.0) return {};
  const double mean = sum / n, spread = std::sqrt(std::max(1e-300, squares / n - mean * mean));
  return {std::abs(mean - calc_mean_rate(recording, joint)) / spread, limited / n};
}

// Mean of the samples that are there; NaN without any.
double calc_mean(const std::vector<double>& series) {
  double n = 0.0, sum = 0.0;
  for (double x : series) {
    if (std::isfinite(x)) {
      n += 1.0;
      sum += x;
    }
  }
  return sum / n;
}

}  // namespace

// A log that samples an oscillation always in the same phase shows a constant velocity, whatever the position does.
Hum find_hum(const Experiment& e) {
  const Plant plant = make_plant(e, {});
  Hum hum;
  for (int j = 0; j < e.num_joints(); ++j) {
    bool hums = false, shakes = false;
    for (const Recording& r : e.recordings) {
      const Readings readings =
          read_joint(r, r.joints[static_cast<size_t>(j)], plant.laws[static_cast<size_t>(j)].effort_limit);
      hums = hums || (readings.limited > kHalf && readings.off > kFarOff);
      shakes = shakes || readings.off > kOff;
    }
    if (hums) hum.humming.push_back(j);
    if (shakes) hum.shaken.push_back(j);
  }
  return hum;
}

Experiment take_out_hum(Experiment e, const Hum& hum) {
  const Plant plant = make_plant(e, {});
  for (int j = 0; j < e.num_joints(); ++j) {
    if (has(hum.shaken, j)) continue;
    for (Recording& r : e.recordings) {
      JointColumns& joint = r.joints[static_cast<size_t>(j)];
      if (!joint.has(Quantity::kPosition) || !joint.has(Quantity::kVelocity) || !joint.has(Quantity::kEffort)) continue;
      const double dv = calc_mean(joint.signal[1]) - calc_mean_rate(r, joint);
      if (!std::isfinite(dv)) continue;
      for (double& v : joint.signal[1]) v -= dv;
      for (double& u : joint.signal[2]) u += plant.laws[static_cast<size_t>(j)].kd * dv;
    }
  }
  return e;
}

}  // namespace hrp::diagnosis
