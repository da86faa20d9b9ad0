// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/regression.h"

namespace hrp::diagnosis {
namespace {

constexpr double kSingular = 1e-6;  // relative ridge: a column with less variance of its own is singular

}  // namespace

Regression solve_gram(const Eigen::MatrixXd& gram, const Eigen::VectorXd& projection) {
  const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd A = scale.asDiagonal() * gram * scale.asDiagonal();
  A.diagonal().array() += kSingular;
  const Eigen::VectorXd b = scale.cwiseProduct(projection);
  const Eigen::VectorXd x = A.ldlt().solve(b);
  return {x.cwiseProduct(scale), x.dot(b)};
}

}  // namespace hrp::diagnosis
