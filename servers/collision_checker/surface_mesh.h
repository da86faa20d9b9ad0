// SPDX-License-Identifier: BSD-3-Clause
// A fixed surface as contacts need it: triangles with their neighbours, and which of them a box reaches.
#pragma once

#include <array>
#include <vector>

#include "common/robot/surface.h"
#include "servers/collision_checker/narrow_phase.h"

namespace hrp {

// How two neighbouring triangles meet, seen from outside. A border is a ridge.
enum class EdgeKind : signed char { kFlat, kRidge, kValley };

// Edge k runs from corner k to corner k + 1.
struct Face {
  std::array<int, 3> corners{};                 // of vertices
  std::array<int, 3> neighbours{{-1, -1, -1}};  // faces, -1 at a border
  std::array<EdgeKind, 3> edges{{EdgeKind::kRidge, EdgeKind::kRidge, EdgeKind::kRidge}};
  Vector3d n;                 // unit, outward
  std::array<Vector3d, 3> m;  // unit, in the plane of the triangle, away from it across edge k
};

// A box in the surface's frame G.
struct QueryBox {
  Transform X_GB;
  Vector3d half = Vector3d::Zero();  // [m] half of its edges
  int shape = 0;                     // the same box as SurfaceMesh::add_query() has it
};

class SurfaceMesh {
 public:
  explicit SurfaceMesh(const Surface& surface);

  const std::vector<Face>& faces() const { return faces_; }
  const Vector3d& get_corner(const Face& face, int k) const { return vertices_[size_t(face.corners[size_t(k)])]; }
  Vector3d calc_middle(const Face& face) const {
    return (get_corner(face, 0) + get_corner(face, 1) + get_corner(face, 2)) / 3.0;
  }
  // [m] Points deeper than this below a triangle are not inside of the body that it bounds. A grid is solid all the way
  // down.
  double deepest() const { return deepest_; }

  // Registers a box of these edges [m]; the number is for QueryBox::shape.
  int add_query(const Vector3d& size);
  // Triangles that a box may touch; those of a grid that lie above the box's lower side are among them.
  void find_faces(const QueryBox& box, std::vector<int>* found);

 private:
  void link_neighbours();
  void classify_edges();
  void find_in_grid(const Vector3d& low, const Vector3d& high, std::vector<int>* found) const;

  std::vector<Vector3d> vertices_;
  std::vector<Face> faces_;
  Vector3d low_, high_;  // [m] box that holds the surface
  int columns_ = 0, rows_ = 0;
  double spacing_ = 0.0, deepest_ = 0.0;
  NarrowPhase narrow_;  // a mesh's tree
  int tree_ = -1;
};

}  // namespace hrp
