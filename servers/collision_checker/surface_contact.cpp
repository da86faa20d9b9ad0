// SPDX-License-Identifier: BSD-3-Clause
#include "servers/collision_checker/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/robot/mesh.h"
#include "common/robot/surface_file.h"
#include "servers/collision_checker/sole_contact.h"

namespace hrp {
namespace {

constexpr double kSeam = 1e-9;  // [m] a point on the seam of two triangles belongs to both
// [m] a point that is in both sides of a valley has left both triangles by its depth
constexpr double kValleyReach = 5e-3;
constexpr double kSameNormal = 0.99;  // cosine
constexpr double kSamePlace = 1e-6;   // [m]
constexpr double kQuerySlack = 1e-3;  // [m] around the box of a shape: FCL's tests are not exact

constexpr double kJustInside = 0.05;  // millimetres of overlap against centimetres of a shape

constexpr int kCylinderSides = 16;
constexpr size_t kMostPlanes = 64;   // of a mesh whose planes are all its sides; each ridge is clipped by all
constexpr double kSamePlane = 1e-4;  // [rad] as flat bends (surface_mesh.cpp)

// One way out of the surface for a point.
struct Exit {
  const Face* face = nullptr;  // nullptr: a ridge
  Vector3d n;
  double clearance = 0.0;  // [m] negative inside
};

struct Ball {
  Vector3d p;  // [m] in G
  double radius = 0.0, margin = 0.0;
};

bool is_above_face(const SurfaceMesh& surface, const Face& face, const Vector3d& p) {
  for (int k = 0; k < 3; ++k) {
    const double outside = (p - surface.get_corner(face, k)).dot(face.m[size_t(k)]);
    if (outside > (face.edges[size_t(k)] == EdgeKind::kValley ? kValleyReach : kSeam)) return false;
  }
  return true;
}

bool find_face_exit(const SurfaceMesh& surface, const Face& face, const Ball& ball, Exit* exit) {
  const double height = face.n.dot(ball.p - surface.get_corner(face, 0));
  if (height - ball.radius >= ball.margin || -height > surface.deepest() || !is_above_face(surface, face, ball.p))
    return false;
  *exit = {&face, face.n, height - ball.radius};
  return true;
}

// A ball beside edge k: outside of both triangles that meet there. Each edge is looked at from one of its triangles.
bool find_ridge_exit(const SurfaceMesh& surface, const Face& face, size_t k, const Ball& ball, Exit* exit) {
  const int other = face.neighbours[k];
  if (face.edges[k] != EdgeKind::kRidge || (other >= 0 && &surface.faces()[size_t(other)] < &face)) return false;
  const Vector3d &a = surface.get_corner(face, static_cast<int>(k)),
                 &b = surface.get_corner(face, static_cast<int>(k + 1) % 3);
  const double t = std::clamp((ball.p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  const Vector3d away = ball.p - (a + t * (b - a));
  const double distance = away.norm();
  if (!(distance > 0.0) || distance - ball.radius >= ball.margin) return false;
  if (face.m[k].dot(away) < 0.0 || is_above_face(surface, face, ball.p)) return false;
  if (other >= 0 && is_above_face(surface, surface.faces()[size_t(other)], ball.p)) return false;
  *exit = {nullptr, away / distance, distance - ball.radius};
  return true;
}

// Both sides of a valley keep a point in: each stands in front of the other.
bool are_valley(const SurfaceMesh& surface, const Face& a, const Face& b) {
  return a.n.dot(b.n) < kSameNormal && a.n.dot(surface.calc_middle(b) - surface.get_corner(a, 0)) > 1e-9 &&
         b.n.dot(surface.calc_middle(a) - surface.get_corner(b, 0)) > 1e-9;
}

void add_exit(const Ball& ball, const Exit& exit, std::vector<ContactPoint>* points) {
  const Vector3d p = ball.p - (ball.radius + 0.5 * exit.clearance) * exit.n;
  for (const ContactPoint& other : *points) {
    if ((other.p_WC - p).squaredNorm() < kSamePlace * kSamePlace && other.n_BA_W.dot(exit.n) > kSameNormal) return;
  }
  points->push_back({p, exit.n, -exit.clearance});
}

// A ball whose middle is outside touches whatever is within its radius. A middle that is inside leaves by the nearest
// way, and by those on the other sides of valleys.
class BallContact {
 public:
  BallContact(const SurfaceMesh& surface, const std::vector<int>& faces) : surface_(surface), faces_(faces) {}

  void add(const Ball& ball, std::vector<ContactPoint>* points) {
    find_exits(ball);
    const Exit* nearest = nullptr;
    for (const Exit& exit : exits_) {
      if (is_inside(ball, exit) && (nearest == nullptr || exit.clearance > nearest->clearance)) nearest = &exit;
    }
    for (const Exit& exit : exits_) {
      const bool inside = nearest != nullptr && is_inside(ball, exit);
      const bool way_out = inside ? &exit == nearest || are_valley(surface_, *nearest->face, *exit.face)
                                  : exit.face != nullptr || nearest == nullptr;
      if (way_out) add_exit(ball, exit, points);
    }
  }
  // True when this triangle is a way out as in add().
  bool is_way_out(const Ball& ball, const Exit& own) {
    find_exits(ball);
    if (is_inside(ball, own) && is_beyond(ball.p, own)) return false;
    return !is_inside(ball, own) || std::none_of(exits_.begin(), exits_.end(), [&](const Exit& e) {
      return is_inside(ball, e) && e.clearance > own.clearance + kSeam && e.n.dot(own.n) < kSameNormal &&
             !are_valley(surface_, *e.face, *own.face);
    });
  }

 private:
  static bool is_inside(const Ball& ball, const Exit& exit) {
    return exit.face != nullptr && exit.clearance < -ball.radius;
  }
  // From outside a thin wall the way down to its far side passes its near side first: nothing to leave.
  bool is_beyond(const Vector3d& p, const Exit& exit) const {
    const double length = -exit.n.dot(p - surface_.get_corner(*exit.face, 0));
    return std::any_of(faces_.begin(), faces_.end(), [&](int i) {
      const Face& near = surface_.faces()[size_t(i)];
      const double height = near.n.dot(p - surface_.get_corner(near, 0)), facing = -near.n.dot(exit.n);
      return height > 0.0 && facing > 0.0 && height < length * facing &&
             is_above_face(surface_, near, p + height / facing * exit.n);
    });
  }
  void find_exits(const Ball& ball) {
    exits_.clear();
    Exit exit;
    for (const int i : faces_) {
      const Face& face = surface_.faces()[size_t(i)];
      if (find_face_exit(surface_, face, ball, &exit) && !(is_inside(ball, exit) && is_beyond(ball.p, exit)))
        exits_.push_back(exit);
      if (ball.radius <= 0.0) continue;
      for (size_t k = 0; k < 3; ++k) {
        if (find_ridge_exit(surface_, face, k, ball, &exit)) exits_.push_back(exit);
      }
    }
  }

  const SurfaceMesh& surface_;
  const std::vector<int>& faces_;
  std::vector<Exit> exits_;
};

// The points of a rim depend on the normal that they meet.
void add_rim(const SurfaceMesh& surface, const std::vector<int>& faces, const SoleRim& rim, const Transform& X_GL,
             double margin, BallContact* contact, std::vector<ContactPoint>* points) {
  for (const int i : faces) {
    const Face& face = surface.faces()[size_t(i)];
    Vector3d p[4];
    calc_rim_points(rim, X_GL, face.n, p);
    for (const Vector3d& each : p) {
      const Ball ball{each, 0.0, margin};
      Exit exit;
      if (find_face_exit(surface, face, ball, &exit) && contact->is_way_out(ball, exit)) add_exit(ball, exit, points);
    }
  }
}

// The part of a segment that is inside all sides: from a + t0 (b - a) to a + t1 (b - a).
bool clip(const std::vector<Side>& sides, const Vector3d& a, const Vector3d& b, double* t0, double* t1) {
  *t0 = 0.0;
  *t1 = 1.0;
  for (const Side& side : sides) {
    const double from = side.d - side.n.dot(a), to = side.d - side.n.dot(b);  // [m] below the side
    if (from < 0.0 && to < 0.0) return false;
    if (from >= 0.0 && to >= 0.0) continue;
    const double t = from / (from - to);
    if (from < 0.0)
      *t0 = std::max(*t0, t);
    else
      *t1 = std::min(*t1, t);
  }
  return *t1 > *t0;
}

// The side through which the segment leaves the shape with the shortest way, among those that face the ridge. None if
// another way is far shorter: then an end of the ridge is just inside, and the other ridges that meet there carry it.
const Side* find_way_out(const std::vector<Side>& sides, const Vector3d& a, const Vector3d& b,
                         const Vector3d& outward) {
  const Side* best = nullptr;
  double least = std::numeric_limits<double>::infinity(), least_of_all = least;
  for (const Side& side : sides) {
    const double depth = side.d - std::min(side.n.dot(a), side.n.dot(b));
    least_of_all = std::min(least_of_all, depth);
    if (side.n.dot(outward) > -0.1 || depth >= least) continue;  // beyond 84 degrees a side does not rest on the ridge
    least = depth;
    best = &side;
  }
  return least_of_all < kJustInside * least ? nullptr : best;
}

// Ridge k of a face against the sides of a shape, in link axes; appended in G.
void add_ridge(const SurfaceMesh& surface, const Face& face, size_t k, const TouchingShape& shape,
               const Transform& X_GL, std::vector<ContactPoint>* points) {
  const int other = face.neighbours[k];
  if (face.edges[k] != EdgeKind::kRidge || (other >= 0 && &surface.faces()[size_t(other)] < &face)) return;
  const auto to_link = [&](const Vector3d& p_G) -> Vector3d { return X_GL.R.transpose() * (p_G - X_GL.p); };
  const Vector3d a = to_link(surface.get_corner(face, static_cast<int>(k))),
                 b = to_link(surface.get_corner(face, static_cast<int>(k + 1) % 3));
  double t0 = 0.0, t1 = 1.0;
  if (!clip(shape.sides, a, b, &t0, &t1)) return;
  const Vector3d outward_G = other >= 0 ? Vector3d(face.n + surface.faces()[size_t(other)].n).normalized() : face.n;
  const Vector3d from = a + t0 * (b - a), to = a + t1 * (b - a);
  const Side* side = find_way_out(shape.sides, from, to, X_GL.R.transpose() * outward_G);
  if (side == nullptr) return;
  for (const Vector3d& p : {from, to}) {
    const double depth = side->d - side->n.dot(p);
    if (depth > 0.0) add_exit({X_GL * p, 0.0, 0.0}, {nullptr, -(X_GL.R * side->n), -depth}, points);
  }
}

void add_box_sides(const CollisionShape& shape, std::vector<Side>* sides) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Vector3d n = sign * shape.X_LG.R.col(axis);
      sides->push_back({n, n.dot(shape.X_LG.p) + 0.5 * shape.size[axis]});
    }
  }
}

void add_cylinder_sides(const CollisionShape& shape, std::vector<Side>* sides) {
  for (const double sign : {1.0, -1.0}) {
    const Vector3d n = sign * shape.X_LG.R.col(2);
    sides->push_back({n, n.dot(shape.X_LG.p) + 0.5 * shape.size.y()});
  }
  for (int i = 0; i < kCylinderSides; ++i) {
    const double angle = 2.0 * M_PI * i / kCylinderSides;
    const Vector3d n = shape.X_LG.R * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    sides->push_back({n, n.dot(shape.X_LG.p) + shape.size.x()});
  }
}

bool holds(const Side& side, const std::vector<Vector3d>& points) {
  return std::all_of(points.begin(), points.end(),
                     [&](const Vector3d& p) { return side.n.dot(p) <= side.d + kSamePlace; });
}

// The planes of a mesh, in link axes, if it is convex and has few of them; else none.
std::vector<Side> find_planes(const CollisionShape& shape) {
  Mesh mesh = make_outward(load_mesh(shape.mesh, shape.scale));
  for (Vector3d& v : mesh.vertices) v = shape.X_LG * v;
  std::vector<Side> planes;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d &p = mesh.vertices[size_t(a)], &q = mesh.vertices[size_t(b)], &r = mesh.vertices[size_t(c)];
    const Vector3d n = (q - p).cross(r - p).normalized();
    const auto same = [&](const Side& side) { return (side.n - n).norm() < kSamePlane; };
    if (std::any_of(planes.begin(), planes.end(), same)) continue;
    planes.push_back({n, n.dot(p)});
    if (planes.size() > kMostPlanes || !holds(planes.back(), mesh.vertices)) return {};
  }
  return planes;
}

// Of other meshes: how far their points reach along the directions of which make_soles() keeps the outermost ones.
void add_mesh_sides(const Sole& parts, std::vector<Side>* sides) {
  if (!sides->empty()) return;
  for (int i = 0; i < 27; ++i) {
    const int x = i % 3 - 1, y = i / 3 % 3 - 1, z = i / 9 - 1;
    const Vector3d direction(x, y, z);
    if (direction.isZero()) continue;
    Side side{direction.normalized(), -std::numeric_limits<double>::infinity()};
    for (const SolePoint& point : parts.points) side.d = std::max(side.d, side.n.dot(point.p_LQ));
    sides->push_back(side);
  }
}

void add_sides(const CollisionShape& shape, TouchingShape* touching) {
  if (shape.kind == ShapeKind::kBox) add_box_sides(shape, &touching->sides);
  if (shape.kind == ShapeKind::kCylinder) add_cylinder_sides(shape, &touching->sides);
  if (shape.kind == ShapeKind::kMesh) touching->sides = find_planes(shape);
  if (shape.kind == ShapeKind::kMesh) add_mesh_sides(touching->parts, &touching->sides);
}

void update_box(const CollisionShape& shape, TouchingShape* touching) {
  touching->X_LB = shape.X_LG;
  if (shape.kind == ShapeKind::kBox) touching->half = 0.5 * shape.size;
  if (shape.kind == ShapeKind::kSphere) touching->half.setConstant(shape.size.x());
  if (shape.kind == ShapeKind::kCylinder) touching->half = {shape.size.x(), shape.size.x(), 0.5 * shape.size.y()};
  if (shape.kind != ShapeKind::kMesh) return;
  Vector3d low = touching->parts.points.front().p_LQ, high = low;
  for (const SolePoint& point : touching->parts.points) {
    low = low.cwiseMin(point.p_LQ);
    high = high.cwiseMax(point.p_LQ);
  }
  touching->X_LB = {Matrix3d::Identity(), 0.5 * (low + high)};
  touching->half = 0.5 * (high - low);
}

}  // namespace

TouchingShape make_touching_shape(const CollisionShape& shape, const Vector3d& p_LR, double margin) {
  TouchingShape touching;
  touching.parts = make_shape_parts(shape);
  touching.parts.p_LR = p_LR;
  for (const SolePoint& point : touching.parts.points)
    touching.margins.push_back(find_margin(touching.parts, point, margin));
  touching.margin = margin;
  add_sides(shape, &touching);
  update_box(shape, &touching);
  touching.half.array() += margin + kQuerySlack;
  return touching;
}

void calc_surface_contact(const SurfaceMesh& surface, const std::vector<int>& faces, const TouchingShape& shape,
                          const Transform& X_GL, std::vector<ContactPoint>* points) {
  BallContact contact(surface, faces);
  for (size_t i = 0; i < shape.parts.points.size(); ++i) {
    const SolePoint& point = shape.parts.points[i];
    contact.add({X_GL * point.p_LQ, point.radius, shape.margins[i]}, points);
  }
  for (const SoleRim& rim : shape.parts.rims)
    add_rim(surface, faces, rim, X_GL, find_upper_margin(shape.margin), &contact, points);
  if (shape.sides.empty()) return;
  for (const int i : faces) {
    for (size_t k = 0; k < 3; ++k) add_ridge(surface, surface.faces()[size_t(i)], k, shape, X_GL, points);
  }
}

void reduce_by_normal(const Matrix3d& R_WA, int max_points, std::vector<ContactPoint>* points) {
  if (static_cast<int>(points->size()) <= max_points) return;
  constexpr double kLikeNormal = 0.9;  // cosine
  std::vector<ContactPoint> rest = std::move(*points), kept, like, others;
  while (!rest.empty()) {
    const Vector3d n = std::max_element(rest.begin(), rest.end(), [](const auto& a, const auto& b) {
                         return a.depth < b.depth;
                       })->n_BA_W;
    like.clear();
    others.clear();
    for (const ContactPoint& point : rest) (point.n_BA_W.dot(n) > kLikeNormal ? like : others).push_back(point);
    reduce_points(R_WA, n, max_points, &like);
    kept.insert(kept.end(), like.begin(), like.end());
    rest.swap(others);
  }
  *points = std::move(kept);
}

}  // namespace hrp
