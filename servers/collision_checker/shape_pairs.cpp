// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/shape_pairs.h"

#include <cmath>

#include "common/robot/surface_file.h"

namespace hrp {
namespace {

constexpr int kCylinderTriangles = 32;  // around an end; its edge is 0.5 % of the radius inside the rim
constexpr double kEndToEnd = 0.99;      // cosine: ends that meet flat, within 8 degrees

Mesh make_box(const Vector3d& size) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(Vector3d(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5).cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// The two ends; nothing looks at what is between them.
Mesh make_cylinder_ends(double radius, double length) {
  Mesh mesh;
  mesh.vertices = {{0, 0, -0.5 * length}, {0, 0, 0.5 * length}};
  const auto at = [](int k, int end) { return 2 + 2 * (k % kCylinderTriangles) + end; };
  for (int k = 0; k < kCylinderTriangles; ++k) {
    const double angle = 2.0 * M_PI * k / kCylinderTriangles;
    for (const double z : {-0.5, 0.5})
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z * length);
    mesh.triangles.push_back({0, at(k + 1, 0), at(k, 0)});
    mesh.triangles.push_back({1, at(k, 1), at(k + 1, 1)});
  }
  return mesh;
}

Mesh make_triangles(const CollisionShape& shape) {
  if (shape.kind == ShapeKind::kBox) return make_box(shape.size);
  if (shape.kind == ShapeKind::kCylinder) return make_cylinder_ends(shape.size.x(), shape.size.y());
  return make_outward(load_mesh(shape.mesh, shape.scale));
}

}  // namespace

int ShapePairs::add(const CollisionShape& shape) {
  Shape added;
  added.spec = shape;
  added.spec.X_LG = Transform();
  shapes_.push_back(std::move(added));
  return narrow_.add_shape(shape);
}

// Of two meshes the second one: points of the first, ridges of the second.
int ShapePairs::find_surface(int a, int b) const {
  if (is(b, ShapeKind::kMesh)) return b;
  if (is(a, ShapeKind::kMesh)) return a;
  if (is(a, ShapeKind::kCylinder) && is(b, ShapeKind::kBox)) return b;
  if (is(a, ShapeKind::kBox) && is(b, ShapeKind::kCylinder)) return a;
  return -1;
}

SurfaceMesh& ShapePairs::get_surface(int shape) {
  Shape& s = shapes_[size_t(shape)];
  if (!s.surface) {
    Surface surface;
    surface.mesh = make_triangles(s.spec);
    s.surface = std::make_unique<SurfaceMesh>(surface);
  }
  return *s.surface;
}

const TouchingShape& ShapePairs::get_touching(int shape) {
  Shape& s = shapes_[size_t(shape)];
  if (!s.touching) s.touching = std::make_unique<TouchingShape>(make_touching_shape(s.spec, Vector3d::Zero(), 0.0));
  return *s.touching;
}

// S: surface, T: what touches it. `sign` -1: the surface is body a.
bool ShapePairs::calc_on_surface(int surface, const Transform& X_WS, int touching, const Transform& X_WT, double sign,
                                 std::vector<ContactPoint>* points) {
  SurfaceMesh& mesh = get_surface(surface);
  const TouchingShape& shape = get_touching(touching);
  std::vector<int>& queries = shapes_[size_t(surface)].queries;
  if (queries.size() < shapes_.size()) queries.resize(shapes_.size(), -1);
  int& query = queries[size_t(touching)];
  if (query < 0) query = mesh.add_query(2.0 * shape.half);
  const Transform X_ST = X_WS.inverse() * X_WT;
  mesh.find_faces({X_ST * shape.X_LB, shape.half, query}, &faces_);
  points_.clear();
  if (!faces_.empty()) calc_surface_contact(mesh, faces_, shape, X_ST, &points_);
  for (const ContactPoint& point : points_) {
    points->push_back({X_WS * point.p_WC, sign * (X_WS.R * point.n_BA_W), point.depth});
  }
  return !points_.empty();
}

bool ShapePairs::are_ends(const Transform& X_WA, const Transform& X_WB, const std::vector<ContactPoint>& found) const {
  const Vector3d z_B = X_WB.R.col(2);
  return !found.empty() && std::abs(z_B.dot(X_WA.R.col(2))) > kEndToEnd &&
         std::abs(z_B.dot(found.back().n_BA_W)) > kEndToEnd;
}

void ShapePairs::calc_contacts(int a, const Transform& X_WA, int b, const Transform& X_WB, int max_points,
                               std::vector<ContactPoint>* points) {
  const int surface = find_surface(a, b);
  if (surface < 0) {
    const size_t before = points->size();
    narrow_.calc_contacts(a, X_WA, b, X_WB, max_points, points);
    if (!is(a, ShapeKind::kCylinder) || !is(b, ShapeKind::kCylinder)) return;
    std::vector<ContactPoint> found(points->begin() + static_cast<long>(before), points->end());
    if (!are_ends(X_WA, X_WB, found)) return;
    points->resize(before);
    if (!calc_on_surface(b, X_WB, a, X_WA, 1.0, points)) points->insert(points->end(), found.begin(), found.end());
    return;
  }
  const int other = surface == a ? b : a;
  // The outermost points and sides of a mesh are not all of it: whether it touches is for FCL to say.
  const bool coarse = is(other, ShapeKind::kMesh);
  if (coarse && !narrow_.overlaps(a, X_WA, b, X_WB)) return;
  const bool found =
      surface == a ? calc_on_surface(a, X_WA, b, X_WB, -1.0, points) : calc_on_surface(b, X_WB, a, X_WA, 1.0, points);
  if (coarse && !found) narrow_.calc_contacts(a, X_WA, b, X_WB, max_points, points);
}

}  // namespace hrp
