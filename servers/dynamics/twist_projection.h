// SPDX-License-Identifier: BSD-3-Clause
// [H03 eq. 2]: the relative velocity of a pair projected onto the polyhedral cone of the twists that press at every
// contact point.
//
//   minimise |x - x0|^2  subject to  a_i . x >= 0,  x = [l w; v],  a_i = [(r_i x d_i) / l; d_i],  d_i = -n_i
//
// d_i points into the penetration, r_i from the reference point of the pair. Metric (the paper is silent): squared
// speed plus squared angular velocity times l^2, l = ContactSpec::length_scale. Method: Hildreth's, that is projected
// Gauss-Seidel on the dual, with the products of the rows; one sweep costs O(M) for M points and O(M) more for each
// that holds. Started from zero multipliers: equal inputs, equal bits.
#pragma once

#include "common/spatial/transform.h"

namespace hrp {

constexpr int kMaxProjectionPoints = 64;
constexpr int kProjectionSweeps = 50;
constexpr double kProjectionTolerance = 1e-9;  // [m/s]

struct TwistProjection {
  Vector6d x = Vector6d::Zero();  // the projected twist [w; v]
  int sweeps = 0;
  double residual = 0.0;  // [m/s] largest change of the last sweep
};

// Conditions of Karush, Kuhn and Tucker, largest violations: of a_i x >= 0 [m/s], of lambda_i (a_i x) = 0 [m^2/s^2],
// of lambda_i >= 0.
struct ProjectionCheck {
  double infeasible = 0.0;
  double not_complementary = 0.0;
  double not_stationary = 0.0;  // |x - x0 - A^T lambda| [m/s]
  double pulls = 0.0;           // -lambda_i [m/s]
};

class TwistProjector {
 public:
  // Points of one pair. More than kMaxProjectionPoints: the rest is left out.
  void reset(double length_scale);
  void add_point(const Vector3d& r, const Vector3d& n);
  int num_points() const { return num_; }
  TwistProjection project(const Vector6d& twist, int max_sweeps = kProjectionSweeps,
                          double tolerance = kProjectionTolerance);
  // Speed at which the twist x presses at point i [m/s].
  double calc_pressing_speed(int i, const Vector6d& x) const;
  // Of the last project().
  ProjectionCheck check() const;
  // The slope of the projected twist over the twist: takes out what the points that hold span. In [l w; v].
  Matrix6d calc_slope() const;

 private:
  class Work;
  friend void project_both(TwistProjector*, const Vector6d*, TwistProjection*);

  double length_ = 0.1;
  int num_ = 0;
  Vector6d a_[kMaxProjectionPoints];
  double square_[kMaxProjectionPoints];
  double lambda_[kMaxProjectionPoints];
  Vector6d x0_ = Vector6d::Zero();
  Vector6d x_ = Vector6d::Zero();
};

// Two at once, each as its project(): the same bits in half of the time. A sweep is one long chain of sums, each of
// which waits for the one before it; the processor works on both chains at the same time.
void project_both(TwistProjector* projectors, const Vector6d* twists, TwistProjection* results);

}  // namespace hrp
