// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/measurement/floating/words.h"

#include <cstdio>

#include "diagnosis/measurement/floating/candidates.h"

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

Alternative make_alternative(const std::string& effect, const Where& where, std::vector<Estimate> parameters,
                             const std::string& motion) {
  return {effect, find_family(effect), where, std::move(parameters), motion};
}

}  // namespace hrp::diagnosis::floating
