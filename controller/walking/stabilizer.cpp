// SPDX-License-Identifier: BSD-3-Clause
#include "controller/walking/stabilizer.h"

#include <algorithm>
#include <cmath>

namespace hrp::walking {

Vector2d clamp(const Vector2d& x, double limit) { return x.cwiseMax(-limit).cwiseMin(limit); }

Vector2d calc_inclination_turn(const StabilizerSpec& spec, const Vector2d& lean, const Vector2d& rate, double dt,
                               Vector2d* integral) {
  *integral = clamp(*integral + spec.inclination_integral * dt * lean, spec.inclination_limit);
  return clamp(-(spec.inclination_gain * lean + spec.inclination_rate * rate + *integral), spec.inclination_limit);
}

Vector2d update_zmp_damping(const StabilizerSpec& spec, const Vector2d& zmp_error, double dt, const Vector2d& offset) {
  return clamp(offset + dt * (spec.zmp_gain * zmp_error - spec.zmp_return * offset), spec.zmp_limit);
}

Vector2d update_foot_turn(const StabilizerSpec& spec, const Vector2d& torque_error, double dt, const Vector2d& turn) {
  return clamp(turn + dt * (torque_error / spec.foot_damping - turn / spec.foot_return), spec.foot_limit);
}

double update_foot_lift(const StabilizerSpec& spec, double force_error, bool both_feet, double dt, double lift) {
  const double T = both_feet ? spec.height_return_double : spec.height_return_single;
  const double next = lift + dt * (force_error / spec.height_damping - lift / T);
  return std::min(std::max(next, -spec.height_limit), spec.height_limit);
}

double update_landing(const StabilizerSpec& spec, bool touched, double descent, double dt, double lift) {
  if (touched) return std::min(std::max(lift + descent, 0.0), spec.height_limit);
  return lift * std::max(0.0, 1.0 - dt / spec.landing_return);
}

Vector2d calc_step_shift(const StepAdjustmentSpec& spec, const Vector2d& error) {
  return clamp(spec.gain * (error - clamp(error, spec.dead_band)), spec.limit);
}

Follower update_follower(const Follower& now, const Vector2d& goal, double w, double dt) {
  const Vector2d d = now.x - goal, c = now.v + w * d;
  const double decay = std::exp(-w * dt);
  return {goal + decay * (d + dt * c), decay * (c - w * (d + dt * c))};
}

LoadReference distribute(const Vector3d& zmp, const Transform soles[2], bool left_carries, bool right_carries,
                         double weight) {
  const Vector2d left = soles[kLeft].p.head<2>(), right = soles[kRight].p.head<2>(), line = left - right;
  double share = left_carries ? 1.0 : 0.0;
  if (left_carries && right_carries) {
    share = std::min(std::max((zmp.head<2>() - right).dot(line) / line.squaredNorm(), 0.0), 1.0);
  }
  const Vector2d beside = zmp.head<2>() - (right + share * line);
  LoadReference reference;
  for (int side : {kLeft, kRight}) {
    const double f = weight * (side == kLeft ? share : 1.0 - share);
    const Vector3d d = soles[side].R.transpose() * Vector3d(beside.x(), beside.y(), 0.0);
    reference.force[side] = f;
    reference.torque[side] = Vector2d(d.y(), -d.x()) * f;
  }
  return reference;
}

}  // namespace hrp::walking
