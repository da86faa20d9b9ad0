// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/words.h"

#include <cstdio>

namespace hrp::diagnosis::floating {

std::string format(const char* pattern, double a, double b, double c, double d) {
  char text[400];
  std::snprintf(text, sizeof text, pattern, a, b, c, d);
  return text;
}

Estimate make_one(const std::string& name, const std::string& unit, double value, double std) {
  Estimate e;
  e.name = name, e.unit = unit, e.value = {value}, e.std = {std};
  return e;
}

Finding make_finding(EffectId effect, const Where& where, std::vector<Estimate> parameters) {
  const EffectInfo& row = get_effect(effect);
  Finding f;
  f.effect = row.name, f.family = get_family_name(row.family), f.where = where, f.parameters = std::move(parameters);
  return f;
}

Alternative make_alternative(EffectId effect, const Where& where, std::vector<Estimate> parameters, const std::string& motion) {
  const EffectInfo& row = get_effect(effect);
  return {row.name, get_family_name(row.family), where, std::move(parameters), motion};
}

}  // namespace hrp::diagnosis::floating
