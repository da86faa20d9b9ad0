// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/solid_hit.h"

#include <cmath>
#include <limits>

namespace hrp {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// The part of a ray inside a convex solid, with the normals where it goes in and out.
struct Span {
  double in = -kNever, out = kNever;
  Vector3d n_in = Vector3d::Zero(), n_out = Vector3d::Zero();

  void cut(const Span& other) {
    if (other.in > in) {
      in = other.in;
      n_in = other.n_in;
    }
    if (other.out < out) {
      out = other.out;
      n_out = other.n_out;
    }
  }
  std::optional<SolidHit> find_first(const Ray& ray) const {
    if (!(in <= out)) return std::nullopt;
    if (in >= ray.t_min && in <= ray.t_max) return SolidHit{in, n_in};
    if (in < ray.t_min && out >= ray.t_min && out <= ray.t_max) return SolidHit{out, n_out};
    return std::nullopt;
  }
};

// Between two planes |x_axis| <= half.
Span find_slab(const Ray& ray, int axis, double half) {
  Span span;
  const double p = ray.p[axis], d = ray.d[axis];
  if (d == 0.0) {
    if (std::abs(p) > half) span.in = kNever;
    return span;
  }
  const double side = d > 0.0 ? 1.0 : -1.0;
  span.in = (-side * half - p) / d;
  span.out = (side * half - p) / d;
  span.n_in[axis] = -side;
  span.n_out[axis] = side;
  return span;
}

// |p + t d|^2 = radius^2 over the first `axes` coordinates: t^2 d.d + 2 t p.d + p.p - radius^2 = 0.
Span find_round(const Ray& ray, int axes, double radius) {
  Span span;
  const auto p = ray.p.head(axes), d = ray.d.head(axes);
  const double a = d.squaredNorm(), b = p.dot(d), c = p.squaredNorm() - radius * radius;
  if (a == 0.0) {
    if (c > 0.0) span.in = kNever;
    return span;
  }
  const double under = b * b - a * c;
  if (under < 0.0) {
    span.in = kNever;
    return span;
  }
  const double root = std::sqrt(under);
  span.in = (-b - root) / a;
  span.out = (-b + root) / a;
  span.n_in.head(axes) = (p + span.in * d) / radius;
  span.n_out.head(axes) = (p + span.out * d) / radius;
  return span;
}

}  // namespace

Ray move_ray(const Ray& ray_W, const Transform& X_WG) {
  const Matrix3d R_GW = X_WG.R.transpose();
  return {R_GW * (ray_W.p - X_WG.p), R_GW * ray_W.d, ray_W.t_min, ray_W.t_max};
}

std::optional<SolidHit> hit_box(const Ray& ray_G, const Vector3d& edges) {
  Span span = find_slab(ray_G, 0, 0.5 * edges.x());
  span.cut(find_slab(ray_G, 1, 0.5 * edges.y()));
  span.cut(find_slab(ray_G, 2, 0.5 * edges.z()));
  return span.find_first(ray_G);
}

std::optional<SolidHit> hit_sphere(const Ray& ray_G, double radius) {
  return find_round(ray_G, 3, radius).find_first(ray_G);
}

std::optional<SolidHit> hit_cylinder(const Ray& ray_G, double radius, double length) {
  Span span = find_round(ray_G, 2, radius);
  span.cut(find_slab(ray_G, 2, 0.5 * length));
  return span.find_first(ray_G);
}

std::optional<SolidHit> hit_plane(const Ray& ray_G) {
  const double t = -ray_G.p.z() / ray_G.d.z();
  if (!(t >= ray_G.t_min && t <= ray_G.t_max)) return std::nullopt;  // NaN: along the plane
  return SolidHit{t, Vector3d::UnitZ()};
}

std::optional<SolidHit> hit_triangle_plane(const Ray& ray_G, const std::array<Vector3d, 3>& corners) {
  const Vector3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double t = (corners[0] - ray_G.p).dot(n) / ray_G.d.dot(n);
  if (!std::isfinite(t)) return std::nullopt;
  return SolidHit{t, n.normalized()};
}

}  // namespace hrp
