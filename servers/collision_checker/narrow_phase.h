// SPDX-License-Identifier: BSD-3-Clause
// Contact of two shapes through FCL: the only file pair of this folder that includes it.
#pragma once

#include <memory>
#include <vector>

#include "common/robot/mesh.h"
#include "common/robot/robot_description.h"
#include "common/robot/signals.h"

namespace hrp {

class NarrowPhase {
 public:
  NarrowPhase();
  ~NarrowPhase();
  // Adds a shape and returns its number. Throws InputError for meshes that cannot be read. Spheres of radius zero are
  // points: they get a radius of 0.1 mm, which FCL can handle.
  int add_shape(const CollisionShape& shape);
  int add_mesh(const Mesh& mesh);
  // Middle and radius of a sphere, in the geometry's frame, that holds the shape.
  const Vector3d& get_center(int shape) const;
  double get_radius(int shape) const;
  // Appends the contacts of shapes a and b at these poses; at most `max_points` of them, one when a mesh is involved.
  void calc_contacts(int a, const Transform& X_WA, int b, const Transform& X_WB, int max_points,
                     std::vector<ContactPoint>* points);
  // Numbers of the triangles of mesh a, which stands at the origin, that shape b overlaps; in the order of FCL's tree.
  void find_triangles(int a, int b, const Transform& X_AB, std::vector<int>* found);
  bool overlaps(int a, const Transform& X_WA, int b, const Transform& X_WB);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hrp
