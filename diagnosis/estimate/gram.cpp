// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/estimate/gram.h"

#include "diagnosis/estimate/robust.h"

namespace hrp::diagnosis {
namespace {

constexpr double kRidge = 1e-9;  // of each column's own sum of squares

// Scaled to a unit diagonal before it is factored: columns have units of their own.
Eigen::VectorXd calc_scale(const Eigen::MatrixXd& G) {
  return G.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 1.0; });
}

Eigen::LDLT<Eigen::MatrixXd> factor(const Eigen::MatrixXd& G, const Eigen::VectorXd& scale) {
  Eigen::MatrixXd scaled = scale.asDiagonal() * G * scale.asDiagonal();
  scaled.diagonal().array() += kRidge;
  return scaled.ldlt();
}

Eigen::VectorXd solve(const Gram& part) {
  const Eigen::VectorXd scale = calc_scale(part.G);
  return scale.cwiseProduct(factor(part.G, scale).solve(scale.cwiseProduct(part.b)));
}

}  // namespace

void Gram::add_row(const Eigen::VectorXd& x, double y) {
  G.selfadjointView<Eigen::Lower>().rankUpdate(x);
  b += y * x;
  c += y * y;
  n += 1.0;
}

void Gram::add_columns(const Eigen::Ref<const Eigen::MatrixXd>& X, const Eigen::Ref<const Eigen::VectorXd>& y) {
  G.selfadjointView<Eigen::Lower>().rankUpdate(X);
  b.noalias() += X * y;
  c += y.squaredNorm();
  n += static_cast<double>(y.size());
}

void Gram::add(const Gram& other, double factor) {
  G += factor * other.G;
  b += factor * other.b;
  c += factor * other.c;
  n += factor * other.n;
}

Gram Gram::pick(const Columns& columns) const {
  const long p = static_cast<long>(columns.size());
  Gram part(p);
  for (long i = 0; i < p; ++i) {
    part.b[i] = b[columns[static_cast<size_t>(i)]];
    for (long j = 0; j < p; ++j) part.G(i, j) = get(columns[static_cast<size_t>(i)], columns[static_cast<size_t>(j)]);
  }
  part.c = c;
  part.n = n;
  return part;
}

double calc_square(const Gram& gram, const Columns& columns, const Eigen::VectorXd& theta) {
  double square = 0.0;
  for (size_t i = 0; i < columns.size(); ++i) {
    for (size_t j = 0; j < columns.size(); ++j)
      square += theta[static_cast<long>(i)] * theta[static_cast<long>(j)] * gram.get(columns[i], columns[j]);
  }
  return square;
}

Eigen::VectorXd solve(const Gram& gram, const Columns& columns) {
  if (columns.empty()) return {};
  return solve(gram.pick(columns));
}

Eigen::MatrixXd calc_inverse(const Gram& gram, const Columns& columns) {
  const Eigen::MatrixXd G = gram.pick(columns).G;
  const Eigen::VectorXd scale = calc_scale(G);
  return scale.asDiagonal() * factor(G, scale).solve(Eigen::MatrixXd(scale.asDiagonal()));
}

double solve_along(const Gram& gram, const Columns& columns, long first, const Eigen::VectorXd& direction) {
  const long all = static_cast<long>(columns.size()), joined = all - direction.size() + 1;
  // Free columns keep their places; the combination takes the place of its first column.
  Eigen::MatrixXd to_columns = Eigen::MatrixXd::Zero(all, joined);
  for (long c = 0; c < first; ++c) to_columns(c, c) = 1.0;
  to_columns.block(first, first, direction.size(), 1) = direction;
  for (long c = first + direction.size(); c < all; ++c) to_columns(c, c - direction.size() + 1) = 1.0;
  const Gram part = gram.pick(columns);
  Gram along(to_columns.cols());
  along.G = to_columns.transpose() * part.G * to_columns;
  along.b = to_columns.transpose() * part.b;
  return solve(along)[first];
}

double calc_rest(const Gram& gram, const Columns& columns, const Eigen::VectorXd& theta) {
  if (columns.empty()) return gram.c;
  const Gram part = gram.pick(columns);
  return std::max(0.0, gram.c - 2.0 * part.b.dot(theta) + theta.dot(part.G * theta));
}

Gram sum(const std::vector<Gram>& folds, long width) {
  Gram total(width);
  for (const Gram& fold : folds) total.add(fold, 1.0);
  return total;
}

double cross_validate(const std::vector<Gram>& folds, const Gram& total, const Columns& columns) {
  const Gram all = total.pick(columns);
  double rest = 0.0, n = 0.0;
  for (const Gram& fold : folds) {
    if (fold.n <= 0.0) continue;
    const Gram own = fold.pick(columns);
    Eigen::VectorXd theta(all.b.size());
    if (!columns.empty()) {
      const Eigen::MatrixXd G = all.G - own.G;
      const Eigen::VectorXd scale = calc_scale(G);
      theta = scale.cwiseProduct(factor(G, scale).solve(scale.cwiseProduct(all.b - own.b)));
    }
    rest += std::max(0.0, fold.c - 2.0 * own.b.dot(theta) + theta.dot(own.G * theta));
    n += fold.n;
  }
  return n > 0.0 ? rest / n : 0.0;
}

Eigen::MatrixXd calc_covariance(const std::vector<Gram>& folds, const Gram& total, const Columns& columns,
                                const Eigen::VectorXd& theta) {
  const long p = theta.size();
  const Eigen::MatrixXd inverse = calc_inverse(total, columns);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(p, p);
  double count = 0.0;
  for (const Gram& fold : folds) {
    if (fold.n <= 0.0) continue;
    const Gram own = fold.pick(columns);
    const Eigen::VectorXd score = own.b - own.G * theta;
    scores += score * score.transpose();
    count += 1.0;
  }
  return make_robust_covariance(inverse, scores, find_few(count)).robust;
}

}  // namespace hrp::diagnosis
