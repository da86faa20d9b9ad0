// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/twist_projection.h"

#include <algorithm>
#include <cmath>

#include "servers/dynamics/scale_angular.h"

namespace hrp {
namespace {

// Rows divided by their lengths. Their products with each other are found when one is asked for: few points hold.
class UnitRows {
 public:
  UnitRows(const Vector6d* a, const double* square, int num) : num_(num) {
    for (int i = 0; i < num; ++i) {
      rows_[i] = a[i] / std::sqrt(square[i]);
      known_[i] = false;
    }
  }
  const Vector6d& get(int i) const { return rows_[i]; }
  // What a step along row i adds to the speeds along all rows.
  void add_step(int i, double step, double* speed) {
    if (!known_[i]) find_products(i);
    for (int j = 0; j < num_; ++j) speed[j] += step * products_[i][j];
  }

 private:
  void find_products(int i) {
    for (int j = 0; j < num_; ++j) products_[i][j] = rows_[j].dot(rows_[i]);
    known_[i] = true;
  }

  int num_;
  bool known_[kMaxProjectionPoints];
  Vector6d rows_[kMaxProjectionPoints];
  double products_[kMaxProjectionPoints][kMaxProjectionPoints];
};

}  // namespace

// [H03 eq. 2], with rows of length 1. A step along one of them changes the speeds along all by their products with it:
// a point waits for one product and one sum of the point before it, not for a whole dot product.
class TwistProjector::Work {
 public:
  Work(TwistProjector* of, const Vector6d& twist)
      : projector_(*of), x0_(scale_angular(twist, of->length_)), rows_(of->a_, of->square_, of->num_) {
    for (int i = 0; i < projector_.num_; ++i) {
      speed_[i] = rows_.get(i).dot(x0_);
      push_[i] = 0.0;
    }
  }

  // False when it was the last one.
  bool sweep(int max_sweeps, double tolerance) {
    if (result_.sweeps >= max_sweeps) return false;
    double residual = 0.0;
    for (int i = 0; i < projector_.num_; ++i) {
      const double step = std::max(-speed_[i], -push_[i]);
      if (step == 0.0) continue;
      push_[i] += step;
      rows_.add_step(i, step, speed_);
      residual = std::max(residual, std::abs(step));
    }
    result_.residual = residual;
    if (residual <= tolerance) return false;
    ++result_.sweeps;
    return true;
  }

  TwistProjection finish() {
    TwistProjector& of = projector_;
    of.x0_ = of.x_ = x0_;
    for (int i = 0; i < of.num_; ++i) {
      of.x_ += push_[i] * rows_.get(i);
      of.lambda_[i] = push_[i] / std::sqrt(of.square_[i]);
    }
    result_.x = scale_angular(of.x_, 1.0 / of.length_);
    return result_;
  }

 private:
  TwistProjector& projector_;
  Vector6d x0_;
  UnitRows rows_;
  double speed_[kMaxProjectionPoints], push_[kMaxProjectionPoints];
  TwistProjection result_;
};

void TwistProjector::reset(double length_scale) {
  length_ = length_scale;
  num_ = 0;
}

void TwistProjector::add_point(const Vector3d& r, const Vector3d& n) {
  if (num_ == kMaxProjectionPoints) return;
  a_[num_] << r.cross(-n) / length_, -n;
  square_[num_] = a_[num_].squaredNorm();
  ++num_;
}

double TwistProjector::calc_pressing_speed(int i, const Vector6d& x) const {
  return a_[i].dot(scale_angular(x, length_));
}

TwistProjection TwistProjector::project(const Vector6d& twist, int max_sweeps, double tolerance) {
  Work work(this, twist);
  while (work.sweep(max_sweeps, tolerance)) {
  }
  return work.finish();
}

void project_both(TwistProjector* projectors, const Vector6d* twists, TwistProjection* results) {
  TwistProjector::Work first(&projectors[0], twists[0]), second(&projectors[1], twists[1]);
  bool first_goes_on = true, second_goes_on = true;
  while (first_goes_on || second_goes_on) {
    if (first_goes_on) first_goes_on = first.sweep(kProjectionSweeps, kProjectionTolerance);
    if (second_goes_on) second_goes_on = second.sweep(kProjectionSweeps, kProjectionTolerance);
  }
  results[0] = first.finish();
  results[1] = second.finish();
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
