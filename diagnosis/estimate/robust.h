// SPDX-License-Identifier: BSD-3-Clause
// Robust ("sandwich") covariance of a least-squares estimate, with clusters of samples: A^-1 B A^-1, with A = sum x x^T
// and B = sum of g g^T over the clusters' scores g. It holds whatever residuals of one cluster (half a second, a toss,
// a fold) are correlated with; scores of different clusters are taken as independent.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <iterator>

#include "diagnosis/estimate/significance.h"

namespace hrp::diagnosis {

struct RobustCovariance {
  Eigen::MatrixXd robust;  // times `few`
  Eigen::MatrixXd white;   // A^-1: what white noise alone would leave

  // Not below white noise: few clusters can agree by chance. `inflate`: mean square residual, where noise is larger.
  double find_variance(long i, double inflate = 1.0) const { return std::max(robust(i, i), white(i, i) * inflate); }
};

// Of few clusters: their scores sum to zero at the estimate, so that B is too small by (n - 1) / n.
inline double find_few(double clusters) { return clusters > 1.0 ? clusters / (clusters - 1.0) : 1.0; }

// A spread of few values is known badly itself: Student's 97.5 % over that of a normal error. At least two values.
inline double find_widening(size_t values) {
  constexpr double student[] = {12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228};
  const size_t freedom = values - 1;
  return (freedom <= std::size(student) ? student[freedom - 1] : 2.0 + 2.3 / static_cast<double>(freedom)) /
         kNinetyFive;
}

// `inverse`: A^-1; `scatter`: B.
inline RobustCovariance make_robust_covariance(Eigen::MatrixXd inverse, const Eigen::MatrixXd& scatter,
                                               double few = 1.0) {
  Eigen::MatrixXd robust = few * inverse * scatter * inverse.transpose();
  return {std::move(robust), std::move(inverse)};
}

}  // namespace hrp::diagnosis
