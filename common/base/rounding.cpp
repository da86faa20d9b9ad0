// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/rounding.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace hrp {

double round_to(double value, int digits) {
  if (!std::isfinite(value)) return 0.0;
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return std::strtod(text, nullptr);
}

std::string number(double value, int digits) {
  char text[40];
  const double rounded = round_to(value, digits);
  const bool whole = std::abs(rounded) >= std::pow(10.0, digits) && std::abs(rounded) < 1e5;
  if (whole) {
    std::snprintf(text, sizeof text, "%.0f", rounded);
  } else {
    std::snprintf(text, sizeof text, "%.*g", digits, value);
  }
  return text;
}

}  // namespace hrp
