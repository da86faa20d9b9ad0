// SPDX-License-Identifier: BSD-3-Clause
#include "common/plot/solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/robot/mesh.h"

namespace hrp {
namespace {

using Eigen::Vector2d;

// Over the viewer's shoulder; faces turned away keep the ambient part.
Vector3d calc_light(const Camera& camera) {
  const Vector3d d = camera.calc_direction();
  return (0.6 * d + Vector3d(0, 0, 0.9) + 0.1 * Vector3d(-std::sin(camera.azimuth), std::cos(camera.azimuth), 0))
      .normalized();
}

constexpr double kAmbient = 0.6;

std::string make_fill(const Colour& colour, double light) {
  const double shade = kAmbient + (1.0 - kAmbient) * std::max(0.0, light);
  char text[8];
  const auto byte = [shade](double value) {
    return static_cast<int>(std::lround(255.0 * std::clamp(value * shade, 0.0, 1.0)));
  };
  std::snprintf(text, sizeof text, "#%02x%02x%02x", byte(colour.red), byte(colour.green), byte(colour.blue));
  return text;
}

Solid make_box(const Vector3d& size) {
  Solid solid;
  for (int i = 0; i < 8; ++i) {
    solid.vertices.emplace_back((i & 1 ? 0.5 : -0.5) * size.x(), (i & 2 ? 0.5 : -0.5) * size.y(),
                                (i & 4 ? 0.5 : -0.5) * size.z());
  }
  solid.faces = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  return solid;
}

Solid make_cylinder(double radius, double length) {
  constexpr int kSides = 16;
  Solid solid;
  std::vector<int> top, bottom;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2.0 * M_PI * i / kSides;
    const Vector3d p(radius * std::cos(angle), radius * std::sin(angle), 0.5 * length);
    solid.vertices.push_back(p);
    solid.vertices.emplace_back(p.x(), p.y(), -p.z());
    const int next = (i + 1) % kSides;
    solid.faces.push_back({2 * i + 1, 2 * next + 1, 2 * next, 2 * i});
    top.push_back(2 * i);
    bottom.push_back(2 * (kSides - 1 - i) + 1);
  }
  solid.faces.push_back(top);
  solid.faces.push_back(bottom);
  return solid;
}

// Directions spread evenly over the sphere (golden spiral).
std::vector<Vector3d> make_directions(int count) {
  std::vector<Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, angle = M_PI * (3.0 - std::sqrt(5.0)) * i,
                 r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

Solid make_mesh_solid(const CollisionShape& shape) {
  const Mesh mesh = load_mesh(shape.mesh, shape.scale);
  Solid solid;
  std::vector<char> taken(mesh.vertices.size(), 0);
  for (const Vector3d& direction : make_directions(200)) {
    size_t best = 0;
    for (size_t i = 1; i < mesh.vertices.size(); ++i) {
      if (direction.dot(mesh.vertices[i]) > direction.dot(mesh.vertices[best])) best = i;
    }
    if (mesh.vertices.empty() || taken[best]) continue;
    taken[best] = 1;
    solid.vertices.push_back(mesh.vertices[best]);
  }
  return solid;
}

Vector3d calc_normal(const Solid& solid, const std::vector<int>& face) {
  const auto p = [&](size_t i) { return solid.vertices[size_t(face[i])]; };
  return (p(1) - p(0)).cross(p(2) - p(1)).normalized();
}

// +1: `a` hides parts of `b`, -1: the other way round, 0: no face of `a` tells. `gap` is the widest one found so far.
int compare_by_faces(const Solid& a, const Solid& b, const Vector3d& direction, double* gap) {
  int answer = 0;
  for (const std::vector<int>& face : a.faces) {
    const Vector3d n = calc_normal(a, face);
    double nearest = 1e300;
    for (const Vector3d& v : b.vertices) nearest = std::min(nearest, n.dot(v - a.vertices[size_t(face[0])]));
    const double facing = n.dot(direction);
    if (nearest < *gap || std::abs(facing) < 1e-6) continue;
    *gap = nearest;
    answer = facing > 0.0 ? -1 : 1;
  }
  return answer;
}

bool is_in_front(const Solid& a, const Solid& b, const Vector3d& direction) {
  double gap = -1e300;  // [m] of the plane that tells; those that overlap are told by the plane of least overlap
  const int by_a = compare_by_faces(a, b, direction, &gap);
  const int by_b = compare_by_faces(b, a, direction, &gap);  // counts when its gap is wider
  if (by_b != 0) return by_b < 0;
  if (by_a != 0) return by_a > 0;
  return direction.dot(calc_middle(a)) > direction.dot(calc_middle(b));
}

struct Bounds {
  Vector2d low = Vector2d::Constant(1e300), high = Vector2d::Constant(-1e300);
  bool meets(const Bounds& other) const {
    return (low.array() < other.high.array()).all() && (other.low.array() < high.array()).all();
  }
};

Bounds calc_bounds(const Solid& solid, const Camera& camera) {
  Bounds bounds;
  for (const Vector3d& v : solid.vertices) {
    bounds.low = bounds.low.cwiseMin(camera.project(v));
    bounds.high = bounds.high.cwiseMax(camera.project(v));
  }
  return bounds;
}

std::string draw_polygon(const std::vector<Vector2d>& outline, const std::string& fill) {
  return "<polygon fill=\"" + fill + "\" points=\"" + make_points(outline) + "\"/>";
}

std::string draw_solid(const Solid& solid, const Camera& camera) {
  const Vector3d direction = camera.calc_direction(), light = calc_light(camera);
  std::string svg;
  if (solid.faces.empty()) {
    std::vector<Vector2d> points;
    for (const Vector3d& v : solid.vertices) points.push_back(camera.project(v));
    return draw_polygon(find_outline(points), make_fill(solid.colour, 0.6));
  }
  for (const std::vector<int>& face : solid.faces) {
    const Vector3d n = calc_normal(solid, face);
    if (!(n.dot(direction) > 0.0)) continue;
    std::vector<Vector2d> outline;
    for (int i : face) outline.push_back(camera.project(solid.vertices[size_t(i)]));
    svg += draw_polygon(outline, make_fill(solid.colour, n.dot(light)));
  }
  return svg;
}

}  // namespace

Vector3d calc_middle(const Solid& solid) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& v : solid.vertices) sum += v;
  return sum / std::max<double>(1.0, static_cast<double>(solid.vertices.size()));
}

Vector3d Camera::calc_direction() const {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

Vector2d Camera::project(const Vector3d& p_W) const {
  const Vector3d d = calc_direction(), right(-std::sin(azimuth), std::cos(azimuth), 0.0), up = d.cross(right);
  return {middle_x + scale * right.dot(p_W - target_W), middle_y - scale * up.dot(p_W - target_W)};
}

Solid make_solid(const CollisionShape& shape) {
  if (shape.kind == ShapeKind::kBox) return make_box(shape.size);
  if (shape.kind == ShapeKind::kCylinder) return make_cylinder(shape.size.x(), shape.size.y());
  if (shape.kind == ShapeKind::kMesh) return make_mesh_solid(shape);
  Solid sphere;
  for (const Vector3d& direction : make_directions(120)) sphere.vertices.push_back(shape.size.x() * direction);
  return sphere;
}

Solid move_solid(const Transform& X_WG, Solid solid) {
  for (Vector3d& v : solid.vertices) v = X_WG * v;
  return solid;
}

std::vector<Vector2d> find_outline(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  if (points.size() < 3) return points;
  std::vector<Vector2d> hull;
  const auto turn_along = [&hull](auto begin, auto end) {
    const size_t floor = hull.size() + 1;
    for (auto p = begin; p != end; ++p) {
      while (hull.size() > floor) {
        const Vector2d a = hull.back() - hull[hull.size() - 2], b = *p - hull.back();
        if (a.x() * b.y() - a.y() * b.x() > 0.0) break;
        hull.pop_back();
      }
      hull.push_back(*p);
    }
    hull.pop_back();
  };
  turn_along(points.begin(), points.end());
  turn_along(points.rbegin(), points.rend());
  return hull;
}

std::string make_points(const std::vector<Vector2d>& outline) {
  std::string text;
  std::array<char, 64> pair{};
  for (const Vector2d& p : outline) {
    std::snprintf(pair.data(), pair.size(), "%s%.1f,%.1f", text.empty() ? "" : " ", p.x(), p.y());
    text += pair.data();
  }
  return text;
}

std::vector<size_t> find_drawing_order(const std::vector<Solid>& solids, const Camera& camera) {
  const Vector3d direction = camera.calc_direction();
  const size_t n = solids.size();
  std::vector<Bounds> bounds;
  std::vector<size_t> left;
  for (size_t i = 0; i < n; ++i) {
    bounds.push_back(calc_bounds(solids[i], camera));
    left.push_back(i);
  }
  std::sort(left.begin(), left.end(), [&](size_t a, size_t b) {
    return direction.dot(calc_middle(solids[a])) < direction.dot(calc_middle(solids[b]));
  });
  std::vector<std::vector<char>> hides(n, std::vector<char>(n, 0));
  for (size_t i = 0; i < n; ++i) {
    for (size_t j = i + 1; j < n; ++j) {
      if (!bounds[i].meets(bounds[j])) continue;
      (is_in_front(solids[i], solids[j], direction) ? hides[i][j] : hides[j][i]) = 1;
    }
  }
  std::vector<size_t> order;
  while (!left.empty()) {
    // The farthest that hides nothing which is yet to be drawn; of a circle, the farthest.
    const auto free = std::find_if(left.begin(), left.end(), [&](size_t i) {
      return std::none_of(left.begin(), left.end(), [&](size_t j) { return hides[i][j] != 0; });
    });
    const auto next = free == left.end() ? left.begin() : free;
    order.push_back(*next);
    left.erase(next);
  }
  return order;
}

std::string draw_solids(const std::vector<Solid>& solids, const Camera& camera) {
  std::string svg = "<g stroke=\"#333\" stroke-width=\".5\" stroke-linejoin=\"round\">";
  for (size_t i : find_drawing_order(solids, camera)) svg += draw_solid(solids[i], camera) + "\n";
  return svg + "</g>";
}

}  // namespace hrp
