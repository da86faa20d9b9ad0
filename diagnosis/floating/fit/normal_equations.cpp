// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/normal_equations.h"

namespace hrp::diagnosis::floating {

long count_coefficients(const std::vector<Candidate>& effects) {
  long n = 0;
  for (const Candidate& c : effects) n += static_cast<long>(c.terms.size());
  return n;
}

Eigen::VectorXd solve_scaled(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double ridge) {
  if (A.size() > 0 && A.diagonal().minCoeff() <= 0) return Eigen::VectorXd::Constant(b.size(), std::nan(""));
  const Eigen::VectorXd scale = A.diagonal().cwiseSqrt();
  Eigen::MatrixXd S = scale.cwiseInverse().asDiagonal() * A * scale.cwiseInverse().asDiagonal();
  S.diagonal().array() += ridge;
  return scale.cwiseInverse().asDiagonal() * S.ldlt().solve(Eigen::VectorXd(scale.cwiseInverse().asDiagonal() * b));
}

void add_prior(const std::vector<double>& prior, long first, Eigen::MatrixXd* A, Eigen::VectorXd* b) {
  for (size_t i = 0; i < prior.size(); ++i) {
    const long k = first + static_cast<long>(i);
    if ((*A)(k, k) <= 0) {
      A->row(k).setZero();
      A->col(k).setZero();
      (*b)(k) = 0;
    }
    (*A)(k, k) += 1 / (prior[i] * prior[i]);
  }
}

void add_priors(const std::vector<Candidate>& effects, Eigen::MatrixXd* A, Eigen::VectorXd* b) {
  long first = 0;
  for (const Candidate& e : effects) {
    add_prior(e.prior, first, A, b);
    first += static_cast<long>(e.terms.size());
  }
}

}  // namespace hrp::diagnosis::floating
