// SPDX-License-Identifier: BSD-3-Clause
// What every fit here needs of least squares: normal equations of badly scaled parameters, signs, standard deviations
// that allow for residuals that are alike.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace hrp::identification {

struct Estimate {
  double value = 0.0, std = 0.0;
  double relative_std() const { return std / std::abs(value); }  // [M14] table 1
};

// Inverse of a symmetric matrix after its diagonal has been scaled to one. Directions that data do not show at all get
// no more than rounding can tell.
Eigen::MatrixXd invert_scaled(const Eigen::MatrixXd& A);

// x of A x = b; entries that would be negative but may not be are held at zero (an active set; few parameters, few
// rounds). `held` says which.
Eigen::VectorXd solve_signed(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                             const std::vector<bool>& may_be_negative, std::vector<Eigen::Index>* held);

// Sum of the products of scores (one column a block of time) with those up to `lags` blocks away, triangular window
// (Newey and West 1987): the middle of the covariance A^-1 S A^-1.
Eigen::MatrixXd sum_scores(const Eigen::MatrixXd& scores, int lags);

}  // namespace hrp::identification
