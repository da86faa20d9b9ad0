// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/significance.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {
namespace {

bool is_vector(const Effect& effect) { return get_effect(effect.id).vector && effect.p.size() == 3; }

// False if the interval of the stiffness contains infinity, or the value is at a bound.
bool is_elastic(const Effect& effect, const std::vector<double>& std) {
  for (size_t i : {size_t{0}, static_cast<size_t>(get_effect(effect.id).rotor)}) {
    const EffectParameter& info = list_infos(effect.id)[i];
    if (effect.p[i] < 1.01 * info.low || effect.p[i] > 0.99 * info.high) return false;
  }
  return effect.p[0] > kSignificantInJoint * std[0];
}

}  // namespace

bool is_significant(const Effect& effect, const std::vector<double>& std, double distance) {
  const EffectInfo& info = get_effect(effect.id);
  if (info.flexible && std::isinf(info.parameters[0].neutral)) return is_elastic(effect, std);
  if (info.always_shows) return true;
  if (is_vector(effect)) return distance > kSignificantVector;
  for (size_t i = 0; i < effect.p.size(); ++i) {
    const double neutral = list_infos(effect.id)[i].neutral;
    // A scale must differ by 2e-3: laws are known no better.
    const double least = list_infos(effect.id)[i].factor ? 2e-3 : 0.0;
    if (std::isfinite(neutral) && std::abs(effect.p[i] - neutral) > std::max(kSignificantInJoint * std[i], least))
      return true;
  }
  return false;
}

bool is_dry(EffectId id) { return get_effect(id).dry; }

bool sticks(EffectId id) { return get_effect(id).sticks; }

double get_rotor(const Effect& effect) {
  const int rotor = get_effect(effect.id).rotor;
  return rotor < 0 ? 0.0 : effect.p[static_cast<size_t>(rotor)];
}

bool is_rigid_rotor(const Effect& effect) {
  return get_effect(effect.id).rotor >= 0 && !get_effect(effect.id).flexible;
}

bool is_smooth(const Hypothesis& hypothesis) {
  return std::all_of(hypothesis.begin(), hypothesis.end(), [](const Effect& e) { return get_effect(e.id).smooth; });
}

void normalise(Hypothesis* hypothesis) {
  for (Effect& effect : *hypothesis) {
    if (get_effect(effect.id).normalise) get_effect(effect.id).normalise(effect.p.data());
  }
}

}  // namespace hrp::diagnosis
