// SPDX-License-Identifier: BSD-3-Clause
// Contact of a sole with the plane of the ground: exact tests of points, spheres and rims.
#pragma once

#include <vector>

#include "common/robot/signals.h"
#include "common/robot/sole.h"

namespace hrp {

// Fills `pair` (memory reused) with at most `max_points` points; false when nothing touches. Points above the ground by
// less than its margin have a negative depth.
bool calc_sole_contact(const Sole& sole, const Transform& X_WL, const GroundPlane& ground, int max_points,
                       ContactPair* pair);

// [m] A margin of centimetres (contact.model: wrench) is for the lower side of a sole; other points of it have less.
double find_upper_margin(double margin);
double find_margin(const Sole& sole, const SolePoint& point, double margin);

// What remains of a contact patch: the outermost points along `max_points` directions of link A's axes in the plane of
// the patch, first one wins; they span the support polygon and do not depend on depths, which flicker. When the deepest
// point of all is not among them and is more than a tenth deeper than they are (a rounded sole), it replaces the
// shallowest of them.
void reduce_points(const Matrix3d& R_WA, const Vector3d& n_W, int max_points, std::vector<ContactPoint>* points);

// Separating translation: the deepest overlap along its normal. Separating rotation: least-squares plane
// depth = d0 + g . t through the points (t from p_WR in the tangent plane): turning by g x n levels it. Points on one
// line, or fewer than two, turn nothing about that line.
void update_separation(ContactPair* pair);

}  // namespace hrp
