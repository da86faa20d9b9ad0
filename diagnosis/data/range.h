// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace hrp::diagnosis {

// Range of the finite values; 0 for none.
inline double calc_range(const std::vector<double>& values) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (double v : values) {
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  return high > low ? high - low : 0.0;
}

}  // namespace hrp::diagnosis
