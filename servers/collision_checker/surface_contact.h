// SPDX-License-Identifier: BSD-3-Clause
// Contacts of convex shapes with the triangles of a surface. FCL finds the triangles (surface_mesh.h); points, normals
// and depths are computed here, since FCL gives one contact a triangle whose normal may lie across the seam of two of
// them.
//
//   corners, spheres and rims of the shape below a triangle     normal of the triangle
//   spheres beside a ridge of the surface                       away from the ridge
//   ridges of the surface inside the shape                      against the nearest side of the shape
#pragma once

#include <vector>

#include "common/robot/signals.h"
#include "common/robot/sole.h"
#include "servers/collision_checker/surface_mesh.h"

namespace hrp {

// Points p with n . p <= d [m] are inside.
struct Side {
  Vector3d n;
  double d = 0.0;
};

// One collision shape of a link, in link axes.
struct TouchingShape {
  Sole parts;                        // its corners, spheres, rims
  std::vector<double> margins;       // [m] of parts.points: above a surface by less than this they are found, too
  double margin = 0.0;               // [m] the largest of them
  std::vector<Side> sides;           // none for a sphere
  Transform X_LB;                    // box that holds the shape
  Vector3d half = Vector3d::Zero();  // [m] half of its edges, margin included
};

// `contact.margin` of the scenario; `p_LR`: the reference point of the shape's link (sole.h).
TouchingShape make_touching_shape(const CollisionShape& shape, const Vector3d& p_LR, double margin);

// Appends contacts, in the surface's frame G. `faces`: what SurfaceMesh::find_faces() gave for the shape's box.
void calc_surface_contact(const SurfaceMesh& surface, const std::vector<int>& faces, const TouchingShape& shape,
                          const Transform& X_GL, std::vector<ContactPoint>* points);

// Points with like normals are reduced together (sole_contact.h): what stands on a step and touches the next one keeps
// both.
void reduce_by_normal(const Matrix3d& R_WA, int max_points, std::vector<ContactPoint>* points);

}  // namespace hrp
