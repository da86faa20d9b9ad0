// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/effect.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

bool is_fitted(const EffectParameter& parameter) { return parameter.stated && !parameter.nuisance; }

// A sensor's fault is one number where one number is read, and where its axes have it in common.
bool is_one_number(const EffectInfo& info, const Place& place) {
  return is_of_joint(place.reading) || (place.kind == PlaceKind::kSensor && !info.vector);
}

}  // namespace

const char* get_unit(Reading reading) {
  switch (reading) {
    case Reading::kPosition: case Reading::kOrientation: return "rad";
    case Reading::kVelocity: case Reading::kAngularVelocity: return "rad/s";
    case Reading::kEffort: case Reading::kTorque: return "N m";
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

std::vector<double> make_values(const Effect& effect) {
  const EffectInfo& info = get_effect(effect.id);
  const bool one = is_one_number(info, effect.place);
  std::vector<double> values;
  size_t at = 0;
  for (const EffectParameter& p : info.parameters) {
    const bool repeated = one && p.axis > 0;
    if (!is_fitted(p))
      values.push_back(p.value);
    else
      values.push_back(std::clamp(effect.p[repeated ? at - 1 : at++], p.low, p.high));
  }
  return values;
}

}  // namespace hrp::diagnosis
