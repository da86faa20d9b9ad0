// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/significance.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

// Value of a parameter at which its effect is absent; NaN where it only describes the effect's shape.
double find_neutral(const Effect& effect, size_t i) {
  if (list_infos(effect.id)[i].factor) return 1.0;
  return i == 0 ? 0.0 : std::nan("");
}

bool is_vector(const Effect& effect) {
  return effect.id == EffectId::kComError || effect.id == EffectId::kExternalForce;
}

// A stiffness whose interval holds infinity, or one at a bound, is no elasticity.
bool is_elastic(const Effect& effect, const std::vector<double>& std) {
  for (size_t i : {0, 2}) {
    const EffectParameter& info = list_infos(effect.id)[i];
    if (effect.p[i] < 1.01 * info.low || effect.p[i] > 0.99 * info.high) return false;
  }
  return effect.p[0] > kSignificantInJoint * std[0];
}

}  // namespace

bool is_significant(const Effect& effect, const std::vector<double>& std, double distance) {
  if (effect.id == EffectId::kElasticity) return is_elastic(effect, std);
  if (effect.id == EffectId::kSaturation || effect.id == EffectId::kStribeck) return true;
  if (is_vector(effect)) return distance > kSignificantVector;
  for (size_t i = 0; i < effect.p.size(); ++i) {
    const double neutral = find_neutral(effect, i);
    // 1e-3 of a scale: below what any law is known to.
    const double least = list_infos(effect.id)[i].factor ? 2e-3 : 0.0;
    if (std::isfinite(neutral) && std::abs(effect.p[i] - neutral) > std::max(kSignificantInJoint * std[i], least)) return true;
  }
  return false;
}

bool is_dry(EffectId id) { return id == EffectId::kCoulomb || id == EffectId::kStribeck; }

bool sticks(EffectId id) { return is_dry(id) || id == EffectId::kLoadFriction; }

double get_rotor(const Effect& effect) {
  switch (effect.id) {
    case EffectId::kRotorInertia:
      return effect.p[0];
    case EffectId::kElasticity:
      return effect.p[2];
    case EffectId::kBacklash:
      return effect.p[3];
    default:
      return 0.0;
  }
}

bool is_smooth(const Hypothesis& hypothesis) {
  return std::none_of(hypothesis.begin(), hypothesis.end(), [](const Effect& effect) {
    switch (effect.id) {
      case EffectId::kHysteresis:
      case EffectId::kElasticity:
      case EffectId::kBacklash:
      case EffectId::kSaturation:
        return true;
      default:
        return sticks(effect.id);
    }
  });
}

void normalise(Hypothesis* hypothesis) {
  for (Effect& effect : *hypothesis) {
    if (effect.id != EffectId::kCogging) continue;
    if (effect.p[0] < 0.0) effect.p[0] = -effect.p[0], effect.p[2] += M_PI;
    effect.p[2] -= 2.0 * M_PI * std::floor(effect.p[2] / (2.0 * M_PI));
  }
}

}  // namespace hrp::diagnosis
