// SPDX-License-Identifier: BSD-3-Clause
// From rest to rest with the least jerk: how people move their hands (Flash and Hogan, J. Neuroscience 5, 1985).
#pragma once

#include <algorithm>

namespace hrp {

// Share of the way at share s of the time, 0 before and 1 after.
inline double calc_minimum_jerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

// Its derivative by s.
inline double calc_minimum_jerk_rate(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return 30.0 * s * s * (1.0 - s) * (1.0 - s);
}

}  // namespace hrp
