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
