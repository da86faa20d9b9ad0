// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/families.h"

namespace hrp::diagnosis {

std::string find_family_name(const std::string& effect) {
  const EffectInfo* info = find_effect(effect);
  return info ? get_family_name(info->family) : "zero";
}

bool is_effect(const std::string& name, EffectId id) { return name == get_effect(id).name; }

}  // namespace hrp::diagnosis
