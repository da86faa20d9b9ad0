// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/regression.h"

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {

Regression solve_gram(const Eigen::MatrixXd& gram, const Eigen::VectorXd& projection) {
  const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd A = scale.asDiagonal() * gram * scale.asDiagonal();
  // A column with less variance of its own is singular: two laws agree no better.
  A.diagonal().array() += kAgreement * kAgreement;
  const Eigen::VectorXd b = scale.cwiseProduct(projection);
  const Eigen::VectorXd x = A.ldlt().solve(b);
  return {x.cwiseProduct(scale), x.dot(b)};
}

}  // namespace hrp::diagnosis
