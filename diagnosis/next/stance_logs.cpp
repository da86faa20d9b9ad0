// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/stance_logs.h"

#include "common/effects/effect_target.h"
#include "diagnosis/next/explanations.h"
#include "diagnosis/next/stance_trial.h"

namespace hrp::diagnosis {

std::optional<LogFault> find_log_fault(const Experiment& experiment, const Json& effect) {
  Effect found;
  if (!read_effect(experiment, effect, &found) || found.place.kind != PlaceKind::kSensor) return std::nullopt;
  const bool effort = found.place.reading == Reading::kEffort;
  if (!effort && found.place.reading != Reading::kPosition) return std::nullopt;
  LogFault fault;
  fault.channel = 2 * static_cast<size_t>(found.place.index) + (effort ? 1 : 0);
  EffectTarget target;
  target.sensor = &fault.errors;
  get_effect(found.id).apply(found.p.data(), target);
  return fault;
}

void add_log_faults(const std::vector<LogFault>& faults, size_t channels, std::vector<double>* readings) {
  for (const LogFault& fault : faults) {
    const std::vector<double> real = *readings;
    for (size_t k = fault.channel; k < real.size(); k += channels) {
      const bool inside = k >= channels && k + channels < real.size();
      const double rate = inside ? (real[k + channels] - real[k - channels]) / (2.0 * kStretch) : 0.0;
      (*readings)[k] = fault.errors.scale.x() * (real[k] - fault.errors.delay * rate) + fault.errors.bias.x();
    }
  }
}

}  // namespace hrp::diagnosis
