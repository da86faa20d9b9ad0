// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_readings.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {

StanceReadings::StanceReadings(const Experiment& experiment) : e_(experiment) {
  for (size_t j = 0; j < e_.joint_noise.size(); ++j) {
    for (const Quantity q : {Quantity::kPosition, Quantity::kEffort})
      noise_.push_back(e_.recordings[0].joints[j].has(q) ? e_.joint_noise[j][static_cast<size_t>(q)].sigma : 0.0);
  }
  for (const WrenchSpec& wrench : e_.scenario.sensors.wrenches) {
    for (const char* kind : {"/force/", "/torque/"}) {
      for (const char* axis : {"x", "y", "z"}) {
        const auto noise = e_.other_noise.find("/wrench/" + wrench.name + kind + axis);
        noise_.push_back(noise != e_.other_noise.end() ? noise->second.sigma : 0.0);
      }
    }
  }
  for (double& sigma : noise_) sigma *= std::sqrt(std::min(1.0, e_.sample_time / kStretch));
}

Readings StanceReadings::record(const StanceRun& run, const std::vector<LogFault>& faults) const {
  Readings readings = run.readings;
  add_log_faults(faults, channels(), &readings);
  return readings;
}

Readings StanceReadings::make_weights(const StanceRun& run) const {
  Readings weights(channels(), 0.0);
  for (size_t c = 0; c < weights.size(); ++c) {
    double low = 1e300, high = -1e300;
    for (size_t k = c; k < run.readings.size(); k += weights.size()) {
      low = std::min(low, run.readings[k]);
      high = std::max(high, run.readings[k]);
    }
    if (noise_[c] > 0.0 && high > low) weights[c] = 1.0 / std::hypot(noise_[c], kKnown * (high - low));
  }
  return weights;
}

std::string StanceReadings::get_signal(size_t channel) const {
  const size_t joints = 2 * e_.joint_noise.size();
  if (channel < joints)
    return e_.signal_name(static_cast<int>(channel / 2), channel % 2 == 0 ? Quantity::kPosition : Quantity::kEffort);
  const size_t at = (channel - joints) % 6;
  return "/wrench/" + e_.scenario.sensors.wrenches[(channel - joints) / 6].name + (at < 3 ? "/force/" : "/torque/") +
         "xyz"[at % 3];
}

std::string StanceReadings::get_unit(size_t channel) const {
  const size_t joints = 2 * e_.joint_noise.size();
  if (channel < joints) return channel % 2 == 0 ? "rad" : "N m";
  return (channel - joints) % 6 < 3 ? "N" : "N m";
}

Readings subtract(const Readings& a, const Readings& b, const Readings& weights) {
  Readings difference(std::min(a.size(), b.size()));
  for (size_t k = 0; k < difference.size(); ++k) difference[k] = (a[k] - b[k]) * weights[k % weights.size()];
  return difference;
}

}  // namespace hrp::diagnosis
