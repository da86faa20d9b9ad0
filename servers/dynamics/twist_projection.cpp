// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/twist_projection.h"

#include <algorithm>
#include <cmath>

namespace hrp {
namespace {

Vector6d scale_rotation(const Vector6d& x, double length) {
  Vector6d scaled = x;
  scaled.head<3>() *= length;
  return scaled;
}

}  // namespace

void TwistProjector::reset(double length_scale) {
  length_ = length_scale;
  num_ = 0;
}

void TwistProjector::add_point(const Vector3d& r, const Vector3d& n) {
  if (num_ == kMaxProjectionPoints) return;
  a_[num_] << r.cross(-n) / length_, -n;
  square_[num_] = a_[num_].squaredNorm();
  size_[num_] = std::sqrt(square_[num_]);
  ++num_;
}

double TwistProjector::calc_pressing_speed(int i, const Vector6d& x) const {
  return a_[i].dot(scale_rotation(x, length_));
}

// [H03 eq. 2]
TwistProjection TwistProjector::project(const Vector6d& twist, int max_sweeps, double tolerance) {
  x0_ = scale_rotation(twist, length_);
  Vector6d x = x0_;  // each point waits for the one before: x stays in registers
  std::fill(lambda_, lambda_ + num_, 0.0);
  TwistProjection result;
  for (; result.sweeps < max_sweeps; ++result.sweeps) {
    result.residual = 0.0;
    for (int i = 0; i < num_; ++i) {
      const double step = std::max(-a_[i].dot(x) / square_[i], -lambda_[i]);
      if (step == 0.0) continue;
      lambda_[i] += step;
      x += step * a_[i];
      result.residual = std::max(result.residual, std::abs(step) * size_[i]);
    }
    if (result.residual <= tolerance) break;
  }
  x_ = x;
  result.x = scale_rotation(x, 1.0 / length_);
  return result;
}

Matrix6d TwistProjector::calc_slope() const {
  Matrix6d slope = Matrix6d::Identity();
  for (int i = 0; i < num_; ++i) {
    if (!(lambda_[i] > 0.0)) continue;
    const Vector6d rest = slope * a_[i];  // what the rows before it do not have; nothing when they span it
    if (rest.squaredNorm() > 1e-9 * square_[i]) slope -= rest * rest.transpose() / rest.squaredNorm();
  }
  return slope;
}

ProjectionCheck TwistProjector::check() const {
  ProjectionCheck check;
  Vector6d gap = x_ - x0_;
  for (int i = 0; i < num_; ++i) {
    const double speed = a_[i].dot(x_);
    check.infeasible = std::max(check.infeasible, -speed);
    check.not_complementary = std::max(check.not_complementary, std::abs(lambda_[i] * speed));
    check.pulls = std::max(check.pulls, -lambda_[i]);
    gap -= lambda_[i] * a_[i];
  }
  check.not_stationary = gap.norm();
  return check;
}

}  // namespace hrp
