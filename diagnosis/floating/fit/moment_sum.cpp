// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/floating/fit/moment_sum.h"

#include <cmath>
#include <utility>

namespace hrp::diagnosis::floating {
namespace {

constexpr long kRowsAtOnce = 128;  // a block that stays in the processor's cache

}  // namespace

MomentSum::MomentSum(long columns, std::vector<long> used)
    : columns_(columns),
      used_(std::move(used)),
      x_(static_cast<long>(used_.size()), kRowsAtOnce),
      d_(static_cast<long>(used_.size()), kRowsAtOnce) {
  m_.G = Eigen::MatrixXd::Zero(x_.rows(), x_.rows());
  m_.b = Eigen::VectorXd::Zero(x_.rows());
}

void MomentSum::add(const double* x, const double* d, double y, double e, double w) {
  const double root = std::sqrt(w);
  for (long i = 0; i < x_.rows(); ++i) {
    const double xi = x[used_[static_cast<size_t>(i)]], di = d[used_[static_cast<size_t>(i)]];
    x_(i, filled_) = root * xi;
    d_(i, filled_) = root * di;
    m_.b(i) += w * (y * xi - e * di);
  }
  m_.yy += w * (y * y - e * e);
  m_.total += w;
  m_.noise += w * e * e;
  if (++filled_ == kRowsAtOnce) flush();
}

void MomentSum::flush() {
  if (filled_ > 0 && x_.rows() > 0) {  // Eigen's products divide by their sizes
    m_.G.selfadjointView<Eigen::Lower>().rankUpdate(x_.leftCols(filled_), 1.0);
    m_.G.selfadjointView<Eigen::Lower>().rankUpdate(d_.leftCols(filled_), -1.0);
  }
  filled_ = 0;
}

Moments MomentSum::take() {
  flush();
  m_.G = Eigen::MatrixXd(m_.G.selfadjointView<Eigen::Lower>());
  if (x_.rows() == columns_) return std::move(m_);
  Moments out{Eigen::MatrixXd::Zero(columns_, columns_), Eigen::VectorXd::Zero(columns_), m_.yy, m_.total, m_.noise};
  for (long i = 0; i < x_.rows(); ++i) {
    const long at = used_[static_cast<size_t>(i)];
    out.b(at) = m_.b(i);
    for (long k = 0; k < x_.rows(); ++k) out.G(at, used_[static_cast<size_t>(k)]) = m_.G(i, k);
  }
  return out;
}

}  // namespace hrp::diagnosis::floating
