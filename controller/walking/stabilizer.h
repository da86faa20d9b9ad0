// SPDX-License-Identifier: BSD-3-Clause
// The stabilizer of [H03 section 2.1.4]: body inclination control, ZMP damping control, foot adjusting control. The
// paper names them and gives no equations; these forms are ours, after the descendants that are published
// (docs/experiments.md). Each law is a pure function of its memory, a measurement and the time step.
#pragma once

#include "common/robot/walk_spec.h"
#include "controller/walking/estimate.h"
#include "controller/walking/footsteps.h"

namespace hrp::walking {

// x limited to +-limit, each element.
Vector2d clamp(const Vector2d& x, double limit);

// Body inclination control. lean: roll, pitch of the body beyond its reference [rad], rate [rad/s]. Returns the turn
// (roll, pitch) of the commanded body about the zero moment point: -(gain lean + rate d/dt lean + integral of lean).
Vector2d calc_inclination_turn(const StabilizerSpec& spec, const Vector2d& lean, const Vector2d& rate, double dt,
                               Vector2d* integral);

// ZMP damping control: d/dt offset = gain (zmp - zmp_ref) - return offset. A ZMP ahead of its reference moves the body
// ahead: accelerating forward draws the ZMP back. [m]
Vector2d update_zmp_damping(const StabilizerSpec& spec, const Vector2d& zmp_error, double dt, const Vector2d& offset);

// Foot adjusting control, attitude: the foot yields to a moment beyond the reference, d/dt turn = (tau - tau_ref) / D -
// turn / T, roll and pitch in axes of the sole.
Vector2d update_foot_turn(const StabilizerSpec& spec, const Vector2d& torque_error, double dt, const Vector2d& turn);
// Heights: d/dt lift = ((f_L - f_R) - (f_L - f_R)_ref) / D_z - lift / T_z. The left foot is raised by half of it, the
// right one lowered.
double update_foot_lift(const StabilizerSpec& spec, double force_error, bool both_feet, double dt, double lift);

// Landing: a foot that has met the ground before its time stops there; pressing on would throw the robot up. `descent`:
// how far the reference goes down in this period [m]; lift: height over the reference, given back when the foot may
// carry.
double update_landing(const StabilizerSpec& spec, bool touched, double descent, double dt, double lift);

// Step adjustment: how far beside its plan the next foot goes, for a divergent component `error` [m] beyond its
// reference.
Vector2d calc_step_shift(const StepAdjustmentSpec& spec, const Vector2d& error);

// The body follows feet that have been moved: critically damped, x'' = w^2 (goal - x) - 2 w x', exact for a goal that
// stands still.
struct Follower {
  Vector2d x = Vector2d::Zero(), v = Vector2d::Zero();  // [m], [m/s]
};
Follower update_follower(const Follower& now, const Vector2d& goal, double w, double dt);

// What each foot should carry so that the ZMP is at `zmp`: f_z and moment (roll, pitch) about the middle of the sole in
// its axes, and the share of the left foot. On both feet the share follows the projection on the line between the
// soles.
struct LoadReference {
  double force[2] = {0.0, 0.0};
  Vector2d torque[2] = {Vector2d::Zero(), Vector2d::Zero()};
};
LoadReference distribute(const Vector3d& zmp, const Transform soles[2], bool left_carries, bool right_carries,
                         double weight);

}  // namespace hrp::walking
