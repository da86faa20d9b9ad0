// SPDX-License-Identifier: BSD-3-Clause
// Where a foot touches a plane: points fixed to the link, spheres, and the rims of cylinders.
#pragma once

#include <vector>

#include "common/multibody/state.h"
#include "common/robot/ground_plane.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// A point of the sole, or the centre of a sphere.
struct SolePoint {
  Vector3d p_LQ = Vector3d::Zero();  // [m]
  double radius = 0.0;               // [m]
};

// A rim of a cylinder.
struct SoleRim {
  Vector3d p_LQ = Vector3d::Zero();     // [m] its centre
  Vector3d axis_L = Vector3d::UnitZ();  // unit vector
  double radius = 0.0;                  // [m]
};

// All soles of one link.
struct Sole {
  int link = 0;
  std::vector<SolePoint> points;
  std::vector<SoleRim> rims;
  Vector3d p_LR = Vector3d::Zero();  // [m] reference point: middle of the lower side of the bounding box in link axes
};

// Corners, spheres and rims of one shape, in link axes.
Sole make_shape_parts(const CollisionShape& shape);

// Soles of the robot, by link. Boxes give their corners, spheres themselves, cylinders their rims, meshes the outermost
// points of their convex hull: along 26 directions, and of each flat side (all within 1 mm) along 16 more.
std::vector<Sole> make_soles(const RobotDescription& robot);

// What of a link may touch the ground when the robot does not only stand: geometry as of soles.
struct FallingLink {
  Sole others;                       // shapes that are no soles
  Sole whole;                        // all shapes, the reference point of its soles where it has some
  Vector3d p_LC = Vector3d::Zero();  // [m] middle and radius of a sphere that holds the others
  double radius = 0.0;               // [m]
};

// Of all links that have such shapes, by link. Meshes that cannot be read are left out: nobody has asked for them.
std::vector<FallingLink> make_falling_links(const RobotDescription& robot);

// Smallest distance of a sole above a plane [m]; infinite when it has no point.
double calc_clearance(const Sole& sole, const Transform& X_WL, const GroundPlane& ground);

// The rim's points that touch a plane first: lowest point, and those at quarter turns from it.
void calc_rim_points(const SoleRim& rim, const Transform& X_WL, const Vector3d& n_W, Vector3d p_WQ[4]);

// The state at step 0: the scenario's pose at rest, mimic joints following, and, where the scenario gives no base
// position, the base at the height where the lowest point of the soles touches the ground or a surface.
State make_start_state(const RobotDescription& robot, const Scenario& scenario);

}  // namespace hrp
