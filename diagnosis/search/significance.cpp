// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/significance.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

bool is_vector(const Effect& effect) { return get_effect(effect.id).vector && effect.p.size() == 3; }

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
  if (get_effect(effect.id).always_shows) return true;
  if (is_vector(effect)) return distance > kSignificantVector;
  for (size_t i = 0; i < effect.p.size(); ++i) {
    const double neutral = list_infos(effect.id)[i].neutral;
    // 1e-3 of a scale: below what any law is known to.
    const double least = list_infos(effect.id)[i].factor ? 2e-3 : 0.0;
    if (std::isfinite(neutral) && std::abs(effect.p[i] - neutral) > std::max(kSignificantInJoint * std[i], least)) return true;
  }
  return false;
}

bool is_dry(EffectId id) { return get_effect(id).dry; }

bool sticks(EffectId id) { return get_effect(id).sticks; }

double get_rotor(const Effect& effect) {
  const int rotor = get_effect(effect.id).rotor;
  return rotor < 0 ? 0.0 : effect.p[static_cast<size_t>(rotor)];
}

bool is_smooth(const Hypothesis& hypothesis) {
  return std::all_of(hypothesis.begin(), hypothesis.end(), [](const Effect& e) { return get_effect(e.id).smooth; });
}

void normalise(Hypothesis* hypothesis) {
  for (Effect& effect : *hypothesis) {
    if (effect.id != EffectId::kCogging) continue;
    if (effect.p[0] < 0.0) effect.p[0] = -effect.p[0], effect.p[2] += M_PI;
    effect.p[2] -= 2.0 * M_PI * std::floor(effect.p[2] / (2.0 * M_PI));
  }
}

}  // namespace hrp::diagnosis
