// SPDX-License-Identifier: BSD-3-Clause
// Three-dimensional linear inverted pendulum [K01], as [H03] uses it. The centre of mass stays on the plane
// z = kx x + ky y + zc through the support point's axes [H03 eq. 7]; then
//   xdd = (g / zc) x + u_p / (m zc),  ydd = (g / zc) y - u_r / (m zc)   [H03 eq. 8, 9]
// whatever the plane's slope. An ankle torque is a shift of the zero moment point p: xdd = (g / zc) (x - p).
#pragma once

#include <vector>

#include <Eigen/Dense>

#include "common/spatial/gravity.h"

namespace hrp::walking {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Constraint plane [H03 eq. 7]; also the plane that the feet stand on, zc lower.
struct ConstraintPlane {
  double kx = 0.0, ky = 0.0;
  double calc_height(const Vector2d& x) const { return kx * x.x() + ky * x.y(); }  // [m] over the origin
};

struct Pendulum {
  double zc = 0.8;                    // [m]
  double g = kGravity;                // [m/s^2]
  double calc_time_constant() const;  // Tc = sqrt(zc / g)
};

// Centre of mass, horizontal, world axes.
struct PendulumState {
  Vector2d x = Vector2d::Zero();  // [m]
  Vector2d v = Vector2d::Zero();  // [m/s]
};

// The zero moment point moves from p0 to p1 at constant speed during T [s].
struct ZmpSegment {
  double T = 0.0;
  Vector2d p0 = Vector2d::Zero(), p1 = Vector2d::Zero();
  Vector2d at(double t) const { return T > 0.0 ? Vector2d(p0 + (t / T) * (p1 - p0)) : p1; }
};

// State at time t of a segment that begins in `start`: the closed form of [H03 eq. 8, 9], also for t < 0 or t > T.
// Ankle torques are in p: u_p = -m g p_x, u_r = m g p_y.
//   x(t) = p(t) + (x0 - p0) cosh(t / Tc) + Tc (v0 - pd) sinh(t / Tc)
PendulumState calc_state(const Pendulum& pendulum, const PendulumState& start, const ZmpSegment& segment, double t);

// State at the end of a single support of length Ts over a foot at the origin, in a walk that repeats: every double
// support of length Td brings the next foot by `step` (forward, sideways) [K01 walk primitive; here with double
// support]. With Td = 0: xbar = step / 2, vx = (C + 1) / (Tc S) xbar, vy = (C - 1) / (Tc S) ybar.
PendulumState calc_walk_primitive(const Pendulum& pendulum, const Vector2d& step, double Ts, double Td);

struct PlacementWeights {
  double position = 10.0;  // a
  double velocity = 1.0;   // b
};

// Modified foot placement [K01]: where the next foot must stand so that the state at the end of its single support is
// as close to `target` as it can be, min a |x_d - x_f|^2 + b |v_d - v_f|^2. `end`: state at the end of the single
// support over `foot`. Between the feet the zero moment point moves during Td.
Vector2d calc_placement(const Pendulum& pendulum, const PendulumState& end, const Vector2d& foot,
                        const PendulumState& target, double Ts, double Td, const PlacementWeights& weights = {});

// What grows of a state: x + Tc v, the divergent component of motion. A state whose divergent component is right comes
// to the right orbit by itself: the rest of the difference decays with exp(-t / Tc).
Vector2d calc_divergent(const Pendulum& pendulum, const PendulumState& state);

// Path of the zero moment point p_start -> w1 -> w2 -> p_end, thirds of T, that takes the divergent component of
// `start` to `divergent` with the least excursion of w1 and w2 from p_start. The whole state would take excursions
// beyond the feet.
std::vector<ZmpSegment> calc_transfer(const Pendulum& pendulum, const PendulumState& start, const Vector2d& p_start,
                                      const Vector2d& divergent, const Vector2d& p_end, double T);

}  // namespace hrp::walking
