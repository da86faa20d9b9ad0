// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/information.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

double calc_normal_share(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

}  // namespace

double calc_projected_power(const Comparison& comparison, const Eigen::MatrixXd& known) {
  if (comparison.fisher.size() == 0) return comparison.power;
  Eigen::MatrixXd A = comparison.fisher + known;
  const double small = 1e-12 * std::max(1e-300, A.diagonal().maxCoeff());
  A.diagonal().array() += small;
  const double taken = comparison.along.dot(A.ldlt().solve(comparison.along));
  return std::clamp(comparison.power - taken, 0.0, comparison.power);
}

double calc_decision_probability(double left, double needed, double discrepancy) {
  if (needed <= 0.0) return 1.0;
  if (!(left > 0.0)) return 0.0;
  // Noise changes the difference of two chi2 with a standard deviation of 2 sqrt(grown).
  double share = 0.0, total = 0.0;
  // A predicted difference depends on values that are not known yet: its logarithm is uncertain by about 1, which is
  // averaged over, in steps that a normal distribution does not notice.
  for (double x = -kOutlier; x <= kOutlier; x += kPart) {
    const double weight = std::exp(-0.5 * x * x);
    const double grown = left / (discrepancy * discrepancy) * std::exp(x);
    share += weight * calc_normal_share((grown - needed) / (2.0 * std::sqrt(grown)));
    total += weight;
  }
  return share / total;
}

Eigen::VectorXd calc_expected_std(const Eigen::MatrixXd& fisher, const Eigen::VectorXd& largest) {
  Eigen::MatrixXd A = fisher;
  for (long i = 0; i < A.rows(); ++i) A(i, i) += 1.0 / (largest[i] * largest[i]);
  const Eigen::MatrixXd covariance = A.ldlt().solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  return covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

double calc_information_factor(double discrepancy, double count, double stretches) {
  const double above = std::max(0.0, discrepancy * discrepancy - 1.0);
  return 1.0 / (1.0 + above * std::max(1.0, count / stretches));
}

}  // namespace hrp::diagnosis
