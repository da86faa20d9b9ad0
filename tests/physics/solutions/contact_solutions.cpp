// SPDX-License-Identifier: BSD-3-Clause
#include "tests/physics/solutions/contact_solutions.h"

#include <cmath>

namespace hrp::solutions {

double calc_slide_acceleration(double gravity, double slope, double friction) {
  return gravity * (std::sin(slope) - friction * std::cos(slope));
}

double calc_hunt_crossley_restitution(double v0, double alpha) {
  const double d = 1.5 * alpha;
  double low = 0.0, high = 1.0;  // bisection: the difference falls with e and changes sign once
  for (int i = 0; i < 100; ++i) {
    const double e = 0.5 * (low + high);
    const double gap = d * v0 * (1.0 + e) - std::log((1.0 + d * v0) / (1.0 - d * e * v0));
    (d * e * v0 < 1.0 && gap > 0.0 ? low : high) = e;
  }
  return 0.5 * (low + high);
}

double calc_one_sided_restitution(double v0, double alpha) {
  const double d = 1.5 * alpha;
  return std::sqrt(2.0 * (v0 / d - std::log(1.0 + d * v0) / (d * d))) / v0;
}

}  // namespace hrp::solutions
