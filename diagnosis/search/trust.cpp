// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/trust.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/estimate/ratios.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// By sample: the drive is at its limit, or its servo has not settled since.
std::vector<char> find_loose(const JointLaws& law, const Recording& recording, const SmoothRecording& smooth,
                             size_t joint) {
  const JointColumns& columns = recording.joints[joint];
  const SmoothJoint& motion = smooth.joints[joint];
  const std::vector<double>& log = columns.signal[static_cast<int>(Quantity::kEffort)];
  std::vector<char> loose(recording.size(), 0);
  if (motion.q.empty()) return loose;
  double until = -1e300;
  for (size_t k = 0; k < recording.size(); ++k) {
    double effort = 0.0, q = 0.0, qd = 0.0;
    if (!log.empty() && std::isfinite(log[k])) {
      effort = log[k];
    } else if (!columns.command.empty()) {
      read_command(recording.time, columns, recording.time[k], k, &q, &qd);
      effort = calc_servo_effort(law, q - motion.q[k], qd - motion.qd[k], 0.0);
    }
    if (std::abs(effort) >= (1.0 - kTrace) * law.effort_limit)
      // Several of its time constants, until it has settled again.
      until = recording.time[k] + kSeveralTimes * law.kd / std::max(1e-9, law.kp);
    loose[k] = recording.time[k] <= until;
  }
  return loose;
}

double calc_rms(const std::vector<double>& values, const std::vector<char>& where) {
  double sum = 0.0, count = 0.0;
  for (size_t k = 0; k < values.size(); ++k) {
    if (where[k]) {
      sum += values[k] * values[k];
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

}  // namespace

std::vector<float> find_trust(const Problem& problem, size_t recording) {
  const Experiment& e = *problem.experiment;
  const Recording& data = e.recordings[recording];
  const SmoothRecording& smooth = problem.smooth[recording];
  const size_t width = problem.weights.size();
  const Plant plant = make_plant(e, {});
  std::vector<float> trust;
  if (plant.effort_driven) return trust;
  for (size_t j = 0; j < plant.laws.size(); ++j) {
    const JointLaws& law = plant.laws[j];
    const std::vector<char> loose = find_loose(law, data, smooth, j);
    const double off = kAgreement * calc_rms(smooth.joints[j].qdd, loose);  // [rad/s^2]
    if (off == 0.0) continue;
    if (trust.empty()) trust.assign(data.size() * width, 1.0f);
    // Of a critically damped pull: final position and largest rate.
    const double q = off / (kFollow * kFollow), qd = off / (M_E * kFollow), slack[kQuantities] = {q, qd, law.kp * q};
    for (size_t i = 0; i < kQuantities; ++i) {
      const size_t c = j * kQuantities + i;
      const auto factor = static_cast<float>(1.0 / std::hypot(1.0, slack[i] * problem.weights[c]));
      for (size_t k = 0; k < data.size(); ++k) trust[k * width + c] = loose[k] ? factor : 1.0f;
    }
  }
  return trust;
}

}  // namespace hrp::diagnosis
