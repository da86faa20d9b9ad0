// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/smooth.h"

#include <Eigen/Dense>
#include <algorithm>

namespace hrp::diagnosis::standing {

Smoother::Smoother(const std::vector<double>& time, int half, Parity parity) : kernels_(time.size()), half_(half) {
  // Every second sample: a window twice as wide in samples is the same in time, and never too few for a cubic.
  const auto reach = static_cast<size_t>(parity == Parity::kAll ? half : std::max(half, 6));
  for (size_t k = 0; k < time.size(); ++k) {
    Kernel& kernel = kernels_[k];
    kernel.begin = k >= reach ? k - reach : 0;
    const size_t end = std::min(time.size(), k + reach + 1);
    const double scale = std::max(1e-9, 0.5 * (time[end - 1] - time[kernel.begin]));
    Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
    std::vector<Eigen::Vector4d> rows;
    for (size_t i = kernel.begin; i < end; ++i) {
      const double s = (time[i] - time[k]) / scale;
      const bool seen = parity == Parity::kAll || (i % 2 == 0) == (parity == Parity::kEven);
      const Eigen::Vector4d row = seen ? Eigen::Vector4d(1, s, s * s, s * s * s) : Eigen::Vector4d::Zero();
      N.noalias() += row * row.transpose();
      rows.push_back(row);
    }
    N.diagonal().array() += 1e-12 * N.trace();
    const Eigen::Matrix4d inverse = N.inverse();
    for (const Eigen::Vector4d& row : rows) {
      const Eigen::Vector4d c = inverse * row;
      kernel.value.push_back(c[0]);
      kernel.rate.push_back(c[1] / scale);
      kernel.second.push_back(2 * c[2] / (scale * scale));
    }
  }
}

Series Smoother::run(const std::vector<double>& values) const {
  Series out;
  for (const Kernel& kernel : kernels_) {
    double value = 0, rate = 0, second = 0;
    for (size_t i = 0; i < kernel.value.size(); ++i) {
      const double y = values[kernel.begin + i];
      value += kernel.value[i] * y, rate += kernel.rate[i] * y, second += kernel.second[i] * y;
    }
    out.value.push_back(value), out.rate.push_back(rate), out.second.push_back(second);
  }
  return out;
}

}  // namespace hrp::diagnosis::standing
