// SPDX-License-Identifier: BSD-3-Clause
// What is drawn of contact forces. Pure functions; world axes.
#pragma once

#include <optional>
#include <vector>

#include "common/robot/ground_plane.h"
#include "common/robot/signals.h"

namespace hrp {

// All forces on one link together.
struct LinkForce {
  int link = 0;
  Vector3d p_WC = Vector3d::Zero();    // [m] middle of the contact points, weighed by the sizes of their forces
  Vector3d force = Vector3d::Zero();   // [N] on the link
  Vector3d moment = Vector3d::Zero();  // [N m] about p_WC
};

// One for each link that is touched from outside (by the ground or an obstacle), by link.
std::vector<LinkForce> sum_link_forces(const ContactForces& forces);

// Zero-moment point [m]: where all forces of the ground together have no moment, except about the ground's normal.
// Nothing when they press with less than 1 N. Without a plane, obstacles are the ground: then it lies in the level
// plane at the height of the contact points, weighed by the sizes of their forces.
std::optional<Vector3d> calc_ground_zmp(const ContactForces& forces, const GroundPlane& ground);

// Convex hull, seen from above, of all points that touch the ground [m], counter-clockwise. Empty for less than three.
std::vector<Vector3d> calc_support_polygon(const ContactForces& forces, const GroundPlane& ground);

}  // namespace hrp
