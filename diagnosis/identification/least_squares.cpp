// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/least_squares.h"

#include <algorithm>

namespace hrp::identification {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double kRounding = 1e-12;  // of the largest eigenvalue, after scaling

Vector make_scale(const Matrix& A) { return A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse(); }

}  // namespace

Matrix invert_scaled(const Matrix& A) {
  const Vector scale = make_scale(A);
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(Matrix(scale.asDiagonal() * A * scale.asDiagonal()));
  const double least = kRounding * solver.eigenvalues().cwiseAbs().maxCoeff();
  const Matrix V = scale.asDiagonal() * solver.eigenvectors();
  return V * solver.eigenvalues().cwiseMax(least).cwiseInverse().asDiagonal() * V.transpose();
}

Vector solve_signed(const Matrix& given_A, const Vector& given_b, const std::vector<bool>& may_be_negative,
                    std::vector<Eigen::Index>* held) {
  held->clear();
  for (Eigen::Index round = 0; round <= given_b.size(); ++round) {
    Matrix A = given_A;
    Vector b = given_b;
    for (Eigen::Index i : *held) {
      A.row(i).setZero();
      A.col(i).setZero();
      A(i, i) = 1.0;
      b[i] = 0.0;
    }
    const Vector scale = make_scale(A);
    Vector x =
        scale.asDiagonal() * Matrix(scale.asDiagonal() * A * scale.asDiagonal()).ldlt().solve(scale.cwiseProduct(b));
    bool again = false;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      if (may_be_negative[static_cast<size_t>(i)] || x[i] >= 0.0 || std::count(held->begin(), held->end(), i)) continue;
      held->push_back(i);
      again = true;
    }
    if (!again) return x;
  }
  return Vector::Zero(given_b.size());
}

Matrix sum_scores(const Matrix& scores, int lags) {
  Matrix S = scores * scores.transpose();
  for (int lag = 1; lag <= lags && lag < scores.cols(); ++lag) {
    const Matrix cross = scores.rightCols(scores.cols() - lag) * scores.leftCols(scores.cols() - lag).transpose();
    S += (1.0 - static_cast<double>(lag) / (lags + 1)) * (cross + cross.transpose());
  }
  return S;
}

}  // namespace hrp::identification
