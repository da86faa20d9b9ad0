// SPDX-License-Identifier: BSD-3-Clause
// Where a ray meets one shape: closed forms in double precision. A solid's frame G is that of CollisionShape.
#pragma once

#include <array>
#include <optional>

#include "common/spatial/transform.h"

namespace hrp {

// Points p + t d, t_min <= t <= t_max. t has the unit of length over that of d, which need not be a unit vector.
struct Ray {
  Vector3d p = Vector3d::Zero();  // [m]
  Vector3d d = Vector3d::UnitX();
  double t_min = 0.0, t_max = 1e9;
};

struct SolidHit {
  double t = 0.0;
  Vector3d n_G = Vector3d::UnitZ();  // outward unit normal
};

// The ray with its axes in frame G. t stays the same.
Ray move_ray(const Ray& ray_W, const Transform& X_WG);

// The first point in reach; a ray that starts inside meets the far side. Sizes [m] as CollisionShape::size.
std::optional<SolidHit> hit_box(const Ray& ray_G, const Vector3d& edges);
std::optional<SolidHit> hit_sphere(const Ray& ray_G, double radius);
std::optional<SolidHit> hit_cylinder(const Ray& ray_G, double radius, double length);
// The plane z = 0.
std::optional<SolidHit> hit_plane(const Ray& ray_G);
// The plane of a triangle; whether the ray is between its edges was found out before. Nothing for a ray along the
// plane.
std::optional<SolidHit> hit_triangle_plane(const Ray& ray_G, const std::array<Vector3d, 3>& corners);

}  // namespace hrp
