// SPDX-License-Identifier: BSD-3-Clause
// Contacts of two bodies' shapes, each kind of pair by the way that gives all of its points.
//
//   a mesh with anything, a cylinder with a box      triangles of one, parts of the other (surface_contact.h)
//   two cylinders, end against end                   the same
//   all other pairs                                  FCL
#pragma once

#include <memory>
#include <vector>

#include "servers/collision_checker/narrow_phase.h"
#include "servers/collision_checker/surface_contact.h"

namespace hrp {

class ShapePairs {
 public:
  // Adds a shape and returns its number. Throws InputError for meshes that cannot be read.
  int add(const CollisionShape& shape);
  // Middle and radius of a sphere, in the geometry's frame, that holds the shape.
  const Vector3d& get_center(int shape) const { return narrow_.get_center(shape); }
  double get_radius(int shape) const { return narrow_.get_radius(shape); }
  bool overlaps(int a, const Transform& X_WA, int b, const Transform& X_WB) {
    return narrow_.overlaps(a, X_WA, b, X_WB);
  }
  // Appends the contacts of shapes a and b at these poses: normals from b to a. FCL gives at most `max_points` of them.
  void calc_contacts(int a, const Transform& X_WA, int b, const Transform& X_WB, int max_points,
                     std::vector<ContactPoint>* points);

 private:
  struct Shape {
    CollisionShape spec;                      // in its own geometry frame
    std::unique_ptr<TouchingShape> touching;  // made when they are first needed
    std::unique_ptr<SurfaceMesh> surface;
    std::vector<int> queries;  // by touching shape: its box in `surface`; -1: not asked yet
  };
  bool is(int shape, ShapeKind kind) const { return shapes_[size_t(shape)].spec.kind == kind; }
  bool are_ends(const Transform& X_WA, const Transform& X_WB, const std::vector<ContactPoint>& found) const;
  // The shape of the two whose triangles count; -1: FCL.
  int find_surface(int a, int b) const;
  SurfaceMesh& get_surface(int shape);
  const TouchingShape& get_touching(int shape);
  bool calc_on_surface(int surface, const Transform& X_WS, int touching, const Transform& X_WT, double sign,
                       std::vector<ContactPoint>* points);

  NarrowPhase narrow_;  // numbers as in shapes_
  std::vector<Shape> shapes_;
  std::vector<int> faces_;
  std::vector<ContactPoint> points_;  // in the surface's frame
};

}  // namespace hrp
