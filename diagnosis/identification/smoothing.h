// SPDX-License-Identifier: BSD-3-Clause
// Zero-phase Gaussian low-pass and its derivatives. All signals of a linear relation go through the same kernel, so the
// relation holds for what comes out.
#pragma once

#include <Eigen/Dense>

namespace hrp::identification {

class GaussianFilter {
 public:
  // width: standard deviation of the kernel [s]; amplitude falls to 1/2 at 0.187 / width [Hz].
  GaussianFilter(double width, double period);
  // order 0: smoothed; 1, 2: derivatives [1/s], [1/s^2]. Near the ends order 0 renormalises the part of the kernel that
  // is there; for derivatives and exact relations leave out margin() samples at each end.
  Eigen::VectorXd apply(const Eigen::VectorXd& signal, int order) const;
  // The same at `count` samples only, from `first` on, `stride` apart.
  Eigen::VectorXd sample(const Eigen::VectorXd& signal, int order, Eigen::Index first, Eigen::Index stride,
                         Eigen::Index count) const;
  Eigen::Index margin() const { return half_; }

 private:
  Eigen::Index half_;
  Eigen::VectorXd kernel_[3];
};

}  // namespace hrp::identification
