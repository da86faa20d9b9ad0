// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/ranges.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {

double calc_range(const Ranges& ranges, int joint) {
  const auto& [low, high] = ranges[static_cast<size_t>(joint)];
  return std::max(0.0, high - low);
}

void widen(const std::vector<double>& positions, std::pair<double, double>* range) {
  for (double q : positions) {
    if (std::isfinite(q)) range->first = std::min(range->first, q), range->second = std::max(range->second, q);
  }
}

Ranges list_seen(const Experiment& experiment) {
  Ranges ranges(static_cast<size_t>(experiment.num_joints()), {1e300, -1e300});
  for (const Recording& r : experiment.recordings) {
    for (size_t j = 0; j < r.joints.size() && r.spec.train; ++j) widen(r.joints[j].signal[0], &ranges[j]);
  }
  return ranges;
}

}  // namespace hrp::diagnosis
