// SPDX-License-Identifier: BSD-3-Clause
// What one series of numbers tells of itself.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

namespace hrp::diagnosis {

// Standard deviation of the finite numbers that were added; 0 of fewer than two. And their mean and root mean square.
class Spread {
 public:
  void add(double y);
  double get() const;
  double get_mean() const { return n_ > 0.0 ? sum_ / n_ : 0.0; }
  double get_rms() const { return n_ > 0.0 ? std::sqrt(square_ / n_) : 0.0; }

 private:
  double sum_ = 0.0, square_ = 0.0, n_ = 0.0;
};

// Where between them three samples at equal steps have their extreme, by a parabola: in steps from the middle one, at
// most a half; 0 where that one is not the extreme.
double calc_vertex(double left, double middle, double right);

// Independent looks at what a model leaves in one half-cycle of a motion: at its ends and its middle.
constexpr double kLooks = 3.0;

// Integrated autocorrelation time [samples]: how many samples one independent one stands for. At least 1.
double calc_correlation_time(const Eigen::Ref<const Eigen::VectorXd>& series);

// Value of a series at a place between its samples, counted in steps; beyond an end, that of the end. At least one
// sample.
inline double calc_between(const double* series, size_t size, double place) {
  const double at = place < 0.0 ? 0.0 : place;
  const size_t below = at < static_cast<double>(size - 1) ? static_cast<size_t>(at) : size - 1,
               above = below + 1 < size ? below + 1 : below;
  return series[below] + (at - static_cast<double>(below)) * (series[above] - series[below]);
}

// Variance of a value between groups, beyond the variance of each group's value (DerSimonian and Laird 1986).
double calc_variance_between(const std::vector<double>& values, const std::vector<double>& variances);

}  // namespace hrp::diagnosis
