// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/families.h"

#include <algorithm>

#include "common/base/check.h"

namespace hrp::diagnosis {

std::string find_family_name(const std::string& effect) {
  const EffectInfo* info = find_effect(effect);
  return info ? get_family_name(info->family) : "zero";
}

const EffectInfo& get_effect_of(PlaceKind place, EffectFamily family) {
  const std::vector<EffectInfo>& all = list_effects();
  const auto is_it = [&](const EffectInfo& row) { return row.place == place && row.family == family && row.reported; };
  HRP_CHECK(std::count_if(all.begin(), all.end(), is_it) == 1, "no effect, or several, of a family at a kind of place");
  return *std::find_if(all.begin(), all.end(), is_it);
}

const EffectInfo& get_late_reading() {
  const std::vector<EffectInfo>& all = list_effects();
  return *std::find_if(all.begin(), all.end(), [](const EffectInfo& row) { return row.change.of_rate != 0.0; });
}

const EffectInfo& get_constant_friction() { return *find_effect("coulomb_friction"); }

}  // namespace hrp::diagnosis
