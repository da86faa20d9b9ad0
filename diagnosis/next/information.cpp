// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/next/information.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {
namespace {

// Mean square difference, over the noise, from which the search calls an explanation worse than noise: 1.2^2 - 1.
constexpr double kVisible = 0.44;
// A difference is foreseen to a factor of about e: values that it rests on are not known yet.
constexpr double kForesight = 1.0;
constexpr double kNats = 3.0;  // of evidence, from which a report takes a side

double calc_normal_share(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

}  // namespace

void Comparison::add(const Comparison& other) {
  if (fisher.size() == 0 && other.fisher.size() != 0) {
    along = Eigen::VectorXd::Zero(other.along.size());
    fisher = Eigen::MatrixXd::Zero(other.fisher.rows(), other.fisher.cols());
  }
  power += other.power, count += other.count;
  along += other.along, fisher += other.fisher;
}

double calc_projected_power(const Comparison& comparison, const Eigen::MatrixXd& known) {
  if (comparison.fisher.size() == 0) return comparison.power;
  Eigen::MatrixXd A = comparison.fisher + known;
  const double small = 1e-12 * std::max(1e-300, A.diagonal().maxCoeff());
  A.diagonal().array() += small;
  const double taken = comparison.along.dot(A.ldlt().solve(comparison.along));
  return std::clamp(comparison.power - taken, 0.0, comparison.power);
}

double calc_decision_probability(double left, double count, double discrepancy) {
  if (!(left > 0.0) || !(count > 0.0)) return 0.0;
  const double visible = left / count / (kVisible * discrepancy * discrepancy);
  const double evidence = 0.5 * left / (discrepancy * discrepancy);
  return calc_normal_share(std::log(visible) / kForesight) *
         calc_normal_share((evidence - kNats) / std::sqrt(2.0 * evidence));
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
