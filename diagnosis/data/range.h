// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

inline std::vector<double> keep_finite(const std::vector<double>& values) {
  std::vector<double> finite;
  for (double v : values) {
    if (std::isfinite(v)) finite.push_back(v);
  }
  return finite;
}

// Range of the finite values; 0 for none.
inline double calc_range(const std::vector<double>& values) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (double v : values) {
    if (std::isfinite(v)) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  return high > low ? high - low : 0.0;
}

// [rad or m] Range of a joint's positions over all recordings; 0 for none.
inline double calc_position_range(const Experiment& e, size_t joint) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Recording& r : e.recordings) {
    for (double q : r.joints[joint].signal[0]) {
      if (std::isfinite(q)) {
        low = std::min(low, q);
        high = std::max(high, q);
      }
    }
  }
  return high > low ? high - low : 0.0;
}

}  // namespace hrp::diagnosis
