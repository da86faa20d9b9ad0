// SPDX-License-Identifier: BSD-3-Clause
// Least squares from sums: G = X^T X, b = X^T y, c = y^T y of each fold of the data. Any subset of columns is then
// fitted, cross-validated and compared without another look at the samples.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace hrp::diagnosis {

using Columns = std::vector<long>;

// Stretches of all samples as folds: long enough that errors of one say nothing of the next.
constexpr int kFolds = 16;

struct Gram {
  Eigen::MatrixXd G;  // lower triangle
  Eigen::VectorXd b;
  double c = 0.0, n = 0.0;  // n: samples

  explicit Gram(long width = 0) : G(Eigen::MatrixXd::Zero(width, width)), b(Eigen::VectorXd::Zero(width)) {}
  double get(long i, long j) const { return i >= j ? G(i, j) : G(j, i); }
  void add_row(const Eigen::VectorXd& x, double y);
  // Many rows at once: X (columns of the equations x rows), y (rows).
  void add_columns(const Eigen::Ref<const Eigen::MatrixXd>& X, const Eigen::Ref<const Eigen::VectorXd>& y);
  void add(const Gram& other, double factor);
  // The sums of these columns alone; both triangles.
  Gram pick(const Columns& columns) const;
};

// Parameters of the chosen columns. Directions that the data do not show at all stay near zero (a ridge of 1e-9 of
// each column's own sum of squares).
Eigen::VectorXd solve(const Gram& gram, const Columns& columns);
// Inverse of these columns' normal equations, with the same ridge: times the variance of the noise, it is the
// covariance of their parameters.
Eigen::MatrixXd calc_inverse(const Gram& gram, const Columns& columns);
// Amplitude of a fixed combination of columns: those from `first` on, in the proportion of `direction`. The other
// columns are fitted freely.
double solve_along(const Gram& gram, const Columns& columns, long first, const Eigen::VectorXd& direction);
// Sum of squares that parameters of these columns predict.
double calc_square(const Gram& gram, const Columns& columns, const Eigen::VectorXd& theta);
// Sum of squares that parameters of these columns leave.
double calc_rest(const Gram& gram, const Columns& columns, const Eigen::VectorXd& theta);

Gram sum(const std::vector<Gram>& folds, long width);
// Mean square of each fold predicted from all others.
double cross_validate(const std::vector<Gram>& folds, const Gram& total, const Columns& columns);

// Robust covariance (robust.h) with the folds as clusters.
Eigen::MatrixXd calc_covariance(const std::vector<Gram>& folds, const Gram& total, const Columns& columns,
                                const Eigen::VectorXd& theta);

}  // namespace hrp::diagnosis
