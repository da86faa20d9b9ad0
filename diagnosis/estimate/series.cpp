// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/estimate/series.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimate/shares.h"

namespace hrp::diagnosis {

void Spread::add(double y) {
  if (std::isfinite(y)) {
    sum_ += y;
    square_ += y * y;
    n_ += 1.0;
  }
}

double Spread::get() const { return n_ > 1.0 ? std::sqrt(std::max(0.0, square_ / n_ - sum_ * sum_ / n_ / n_)) : 0.0; }

double calc_correlation_time(const Eigen::Ref<const Eigen::VectorXd>& series) {
  const long n = series.size();
  const double zero = std::max(1e-300, series.squaredNorm());
  double time = 1.0;
  for (long lag = 1; lag < n / 4; ++lag) {
    const double share = series.head(n - lag).dot(series.tail(n - lag)) / zero;
    if (share < kDetail) break;  // samples count as independent from there on
    time += 2.0 * share;
  }
  return time;
}

double calc_vertex(double left, double middle, double right) {
  if (!((left - middle) * (right - middle) > 0.0)) return 0.0;
  return 0.5 * (left - right) / (left - 2.0 * middle + right);
}

double calc_variance_between(const std::vector<double>& values, const std::vector<double>& variances) {
  double w = 0.0, ww = 0.0, mean = 0.0, q = 0.0;
  for (size_t g = 0; g < values.size(); ++g) {
    const double own = 1.0 / std::max(1e-300, variances[g]);
    w += own;
    ww += own * own;
    mean += own * values[g];
  }
  mean /= w;
  for (size_t g = 0; g < values.size(); ++g) q += std::pow(values[g] - mean, 2) / std::max(1e-300, variances[g]);
  const double degrees = static_cast<double>(values.size()) - 1.0, scale = w - ww / w;
  return scale > 0.0 ? std::max(0.0, (q - degrees) / scale) : 0.0;
}

}  // namespace hrp::diagnosis
