// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/step_check.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/search/step_error.h"

namespace hrp::diagnosis {
namespace {

constexpr double kFarOff = 1.0, kOff = 0.1;  // mean velocity off the position's rate, in standard deviations

// Share of the samples in which the nominal servo of a joint is at its limit.
double find_limited(const Problem& problem, const Plant& plant, int joint) {
  const JointLaws& laws = plant.laws[static_cast<size_t>(joint)];
  if (!std::isfinite(laws.effort_limit)) return 0.0;
  const size_t width = plant.laws.size() * kQuantities,
               at = static_cast<size_t>(joint) * kQuantities + static_cast<size_t>(Quantity::kEffort);
  double limited = 0.0, all = 0.0;
  for (int r : problem.train) {
    const auto i = static_cast<size_t>(r);
    std::vector<double> readings;
    const Recording& recording = problem.experiment->recordings[i];
    if (!simulate_recording(add_by_hand(plant, recording.spec), recording, problem.smooth[i], problem.options, &readings)) continue;
    for (size_t k = problem.smooth[i].judged; k < recording.size(); ++k) {
      limited += std::abs(readings[k * width + at]) > 0.999 * laws.effort_limit ? 1.0 : 0.0, all += 1.0;
    }
  }
  return limited / std::max(1.0, all);
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
    n += 1.0, sum += v, squares += v * v, limited += std::abs(u) > (1.0 - kKnown) * limit ? 1.0 : 0.0;
  }
  if (n == 0.0) return {};
  const double mean = sum / n, spread = std::sqrt(std::max(1e-300, squares / n - mean * mean));
  const double rate = (joint.signal[0].back() - joint.signal[0].front()) / recording.duration();
  return {std::abs(mean - rate) / spread, limited / n};
}

}  // namespace

// A log that samples an oscillation always in the same phase shows a constant velocity, whatever the position does.
Hum find_hum(const Experiment& e) {
  const Plant plant = make_plant(e, {});
  Hum hum;
  for (int j = 0; j < e.num_joints(); ++j) {
    bool hums = false, shakes = false;
    for (const Recording& r : e.recordings) {
      const Readings readings = read_joint(r, r.joints[static_cast<size_t>(j)], plant.laws[static_cast<size_t>(j)].effort_limit);
      hums = hums || (readings.limited > kHalf && readings.off > kFarOff);
      shakes = shakes || readings.off > kOff;
    }
    if (hums) hum.humming.push_back(j);
    if (shakes) hum.shaken.push_back(j);
  }
  return hum;
}

std::vector<SuspectJoint> find_suspect_joints(const Problem& problem) {
  const Plant plant = make_plant(*problem.experiment, {});
  const StepErrors errors = estimate_step_errors(problem, {}, problem.train, 2);
  const Score score = calc_score(problem, {}, problem.train);
  std::vector<SuspectJoint> found;
  if (!score.ok) return found;
  const size_t width = problem.weights.size();
  for (size_t c = 0; c < width; ++c) {
    double sum = 0.0, count = 0.0;
    for (int r : problem.train) {
      const std::vector<double>& error = errors[static_cast<size_t>(r)];
      for (size_t k = problem.smooth[static_cast<size_t>(r)].judged; (k + 1) * width <= error.size(); ++k) {
        sum += std::pow(error[k * width + c] * problem.weights[c], 2), count += 1.0;
      }
    }
    const double change = std::sqrt(sum / std::max(1.0, count)), left = score.rms(c);
    if (left <= 0.0 || change < kUnlikely || change < kMuch * left) continue;
    const int joint = static_cast<int>(c) / kQuantities;
    if (!found.empty() && found.back().joint == joint) {
      if (change > found.back().change) found.back().change = change, found.back().left = left;
    } else {
      found.push_back({joint, change, left, find_limited(problem, plant, joint) > kDetail});
    }
  }
  return found;
}

}  // namespace hrp::diagnosis
