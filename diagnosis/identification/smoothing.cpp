// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/smoothing.h"

#include <algorithm>
#include <cmath>

namespace hrp::identification {

GaussianFilter::GaussianFilter(double width, double period)
    : half_(static_cast<Eigen::Index>(std::ceil(4.0 * width / period))) {
  const Eigen::Index size = 2 * half_ + 1;
  for (Eigen::VectorXd& kernel : kernel_) kernel.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const double t = static_cast<double>(i - half_) * period;
    const double g = std::exp(-0.5 * t * t / (width * width));
    kernel_[0][i] = g;
    kernel_[1][i] = t * g;
    kernel_[2][i] = (t * t / (width * width) - 1.0) * g;
  }
  const Eigen::VectorXd t =
      Eigen::VectorXd::LinSpaced(size, -static_cast<double>(half_), static_cast<double>(half_)) * period;
  kernel_[0] /= kernel_[0].sum();
  // A line of slope 1 gives 1; a parabola t^2 / 2 gives 1 and a constant nothing.
  kernel_[1] /= kernel_[1].dot(t);
  kernel_[2] -= kernel_[0] * kernel_[2].sum();
  kernel_[2] /= 0.5 * kernel_[2].dot(t.cwiseAbs2());
}

Eigen::VectorXd GaussianFilter::apply(const Eigen::VectorXd& signal, int order) const {
  return sample(signal, order, 0, 1, signal.size());
}

Eigen::VectorXd GaussianFilter::sample(const Eigen::VectorXd& signal, int order, Eigen::Index first,
                                       Eigen::Index stride, Eigen::Index count) const {
  const Eigen::VectorXd& kernel = kernel_[order];
  const Eigen::Index n = signal.size();
  Eigen::VectorXd result(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const Eigen::Index k = first + j * stride;
    const Eigen::Index low = std::max<Eigen::Index>(0, k - half_), high = std::min<Eigen::Index>(n - 1, k + half_);
    const auto part = kernel.segment(low - k + half_, high - low + 1);
    const double sum = part.dot(signal.segment(low, high - low + 1));
    const bool whole = part.size() == kernel.size();
    result[j] = order > 0 || whole ? sum : sum / part.sum();
  }
  return result;
}

}  // namespace hrp::identification
