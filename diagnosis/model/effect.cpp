// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/effect.h"

#include <algorithm>

#include "common/base/check.h"

namespace hrp::diagnosis {

Effect::Effect(EffectId row, int index, std::vector<double> values)
    : Effect(row, Place{get_effect(row).place, index, Reading::kAll}, std::move(values)) {
  HRP_CHECK(place.kind != PlaceKind::kSensor, "a sensor's fault is of one of its readings");
}

const char* get_unit(Reading reading) {
  switch (reading) {
    case Reading::kPosition:
    case Reading::kOrientation: return "rad";
    case Reading::kVelocity:
    case Reading::kAngularVelocity: return "rad/s";
    case Reading::kEffort:
    case Reading::kTorque: return "N m";
    case Reading::kForce: return "N";
    case Reading::kAcceleration: return "m/s^2";
    default: return "";
  }
}

Effect make_part(const Effect& whole, const EffectPart& part) {
  Effect out(part.id, whole.place, {});
  for (size_t i = 0; i < part.from.size(); ++i) {
    const int from = part.from[i];
    out.p.push_back(from < 0 ? get_effect(part.id).parameters[i].value : whole.p[static_cast<size_t>(from)]);
  }
  return out;
}

bool has_part(EffectId whole, EffectId part) {
  const std::vector<EffectPart>& parts = get_effect(whole).parts;
  return std::any_of(parts.begin(), parts.end(), [&](const EffectPart& p) { return p.id == part; });
}

}  // namespace hrp::diagnosis
