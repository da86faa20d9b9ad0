// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/estimate/free_model.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnosis/estimate/gram.h"

namespace hrp::diagnosis {
namespace {

constexpr int kFeatures = 120;  // random cosines; smooth functions of a dozen quantities need no more
constexpr double kWidth = 1.5;  // of the kernel, in standard deviations of the quantities
constexpr double kRidges[] = {1e-4, 1e-3, 1e-2, 1e-1, 1.0};  // of the samples' number
constexpr long kMostSamples = 6000;

struct Scale {
  Eigen::RowVectorXd mean, inverse;
};

Scale find_scale(const Eigen::MatrixXd& x) {
  Scale s{x.colwise().mean(), Eigen::RowVectorXd(x.cols())};
  const Eigen::MatrixXd centred = x.rowwise() - s.mean;
  for (long c = 0; c < x.cols(); ++c) {
    const double std = std::sqrt(centred.col(c).squaredNorm() / static_cast<double>(std::max(1L, x.rows())));
    s.inverse[c] = std > 1e-12 ? 1.0 / std : 0.0;
  }
  return s;
}

// Quantities themselves, a one, and cosines of random projections.
class Features {
 public:
  explicit Features(const Eigen::MatrixXd& x) : scale_(find_scale(x)), w_(x.cols(), kFeatures), phase_(kFeatures) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal(0.0, 1.0 / kWidth);
    std::uniform_real_distribution<double> uniform(0.0, 2.0 * M_PI);
    for (double& w : w_.reshaped()) w = normal(random);
    for (double& p : phase_) p = uniform(random);
  }
  long width() const { return w_.rows() + 1 + kFeatures; }
  Eigen::VectorXd at(const Eigen::RowVectorXd& x) const {
    const Eigen::RowVectorXd z = (x - scale_.mean).cwiseProduct(scale_.inverse);
    Eigen::VectorXd out(width());
    out << z.transpose(), 1.0, ((z * w_).array() + phase_.array()).cos().matrix().transpose();
    return out;
  }

 private:
  Scale scale_;
  Eigen::MatrixXd w_;
  Eigen::RowVectorXd phase_;
};

std::vector<Gram> sum_folds(const FreeData& data, const Features& features) {
  const int count = data.fold.empty() ? 0 : 1 + *std::max_element(data.fold.begin(), data.fold.end());
  std::vector<Gram> folds(static_cast<size_t>(count), Gram(features.width()));
  const long stride = 1 + data.x.rows() / kMostSamples;
  for (long k = 0; k < data.x.rows(); k += stride) {
    const int fold = data.fold[static_cast<size_t>(k)];
    if (fold >= 0) folds[static_cast<size_t>(fold)].add_row(features.at(data.x.row(k)), data.y[k]);
  }
  return folds;
}

Eigen::VectorXd solve_ridge(const Gram& gram, double ridge) {
  Eigen::MatrixXd G = gram.G.selfadjointView<Eigen::Lower>();
  G.diagonal().array() += ridge * std::max(1.0, gram.n);
  return G.ldlt().solve(gram.b);
}

double calc_rest(const Gram& gram, const Eigen::VectorXd& theta) {
  const Eigen::MatrixXd G = gram.G.selfadjointView<Eigen::Lower>();
  return gram.c - 2.0 * gram.b.dot(theta) + theta.dot(G * theta);
}

}  // namespace

double find_free_share(const FreeData& train, const FreeData& test) {
  if (train.x.rows() < 2 * kFeatures || test.x.rows() == 0) return 0.0;
  const Features features(train.x);
  const std::vector<Gram> folds = sum_folds(train, features);
  const Gram total = sum(folds, features.width());
  double best = 1e300, chosen = kRidges[0];
  for (double ridge : kRidges) {
    double rest = 0.0;
    for (const Gram& fold : folds) {
      Gram others = total;
      others.add(fold, -1.0);
      rest += calc_rest(fold, solve_ridge(others, ridge));
    }
    if (rest < best) {
      best = rest;
      chosen = ridge;
    }
  }
  const Eigen::VectorXd theta = solve_ridge(total, chosen);
  double rest = 0.0;
  for (long k = 0; k < test.x.rows(); ++k) rest += std::pow(test.y[k] - features.at(test.x.row(k)).dot(theta), 2);
  return std::max(0.0, 1.0 - rest / std::max(1e-300, test.y.squaredNorm()));
}

}  // namespace hrp::diagnosis
