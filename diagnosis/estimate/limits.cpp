// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/estimate/limits.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {

double find_student(double normal, double degrees) {
  const double n = std::max(4.0, degrees), z = normal * (8 * n + 3) / (8 * n + 1);
  return std::sqrt(n * (std::exp(z * z / n) - 1));
}

double find_length(double normal, size_t components) {
  const auto chance = [](double z, size_t n) {  // probability to exceed z: chi distribution
    if (n == 2) return std::exp(-0.5 * z * z);
    return std::erfc(z * M_SQRT1_2) + (n == 3 ? z * std::sqrt(2 / M_PI) * std::exp(-0.5 * z * z) : 0.0);
  };
  double low = normal, high = normal + 3;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (chance(middle, components) > chance(normal, 1) ? low : high) = middle;
  }
  return high;
}

}  // namespace hrp::diagnosis
