// SPDX-License-Identifier: BSD-3-Clause
// Where the feet will stand. Plans that legs cannot walk are refused with the number of the step and the reason.
#pragma once

#include <string>
#include <vector>

#include "common/robot/walk_spec.h"
#include "controller/walking/lipm.h"

namespace hrp::walking {

enum Side { kLeft = 0, kRight = 1 };
inline Side other(Side side) { return side == kLeft ? kRight : kLeft; }

// Pose of a sole's reference point: position and heading; tilt is the ground's.
struct Foothold {
  Vector3d p = Vector3d::Zero();  // [m]
  double yaw = 0.0;               // [rad]
  Vector2d xy() const { return p.head<2>(); }
};

struct Footstep {
  Side side = kLeft;  // the foot that moves
  Foothold hold;
};

// Footholds of both feet at the start, by Side.
struct Stance {
  Foothold feet[2];
};

// Steps that the scenario asks for: its list, or those made from count, length, side, turn, with a last step that
// brings the feet side by side. Throws InputError: "step 3 (left): 0.52 m forward, legs reach 0.35 m". `plane`:
// footholds are put on it, beside the heights that the list gives.
std::vector<Footstep> make_footsteps(const WalkSpec& spec, const Stance& start, const ConstraintPlane& plane);

// The place nearest to `goal` (sole's reference point) that the foot on this side reaches from `support`: length and
// width within the plan's limits, along the axes of the supporting foot, so that legs never cross.
Vector2d limit_to_reach(const WalkSpec& spec, Side side, const Foothold& support, const Vector2d& goal);

}  // namespace hrp::walking
