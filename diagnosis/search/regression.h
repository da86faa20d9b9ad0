// SPDX-License-Identifier: BSD-3-Clause
// Linear least squares from sums of products.
#pragma once

#include <Eigen/Dense>

namespace hrp::diagnosis {

struct Regression {
  Eigen::VectorXd x;  // by column
  double gain = 0.0;  // decrease of the sum of squares
};

// Solves from X^T X and X^T y. Columns may have any units; directions without excitation stay at zero.
Regression solve_gram(const Eigen::MatrixXd& gram, const Eigen::VectorXd& projection);

}  // namespace hrp::diagnosis
