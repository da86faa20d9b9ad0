// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace hrp::diagnosis {

// Quantile of the values: the value below which a share (0 to 1) of them lies, without interpolation; 0 for none.
inline double find_quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<long>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Median, the upper one of an even number; 0 for none.
inline double find_median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Standard deviation of a normal distribution, from absolute distances to its centre. Robust against some outliers.
inline double find_deviation(std::vector<double> distances) { return 1.4826 * find_median(std::move(distances)); }

// The same for values about their own median.
inline double find_deviation_about_median(std::vector<double> values) {
  const double middle = find_median(values);
  for (double& v : values) v = std::abs(v - middle);
  return find_deviation(std::move(values));
}

}  // namespace hrp::diagnosis
