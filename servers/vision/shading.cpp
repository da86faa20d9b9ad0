// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/shading.h"

#include <cmath>

namespace hrp {
namespace {

constexpr double kAmbient = 0.4;      // of the light comes from all sides: shaded faces stay apart from black
constexpr double kDarkSquare = 0.82;  // of the colour
constexpr double kSquare = 0.5;       // [m]

// Towards the sun, world axes: high, behind a robot that looks along x, and askew to the axes, so that the faces of a
// box differ.
const Vector3d kSun_W = Vector3d(-0.36, -0.28, 0.88).normalized();

Vector3d find_surface_color(const VisibleShape& shape, const Transform& X_WG, const Ray& ray_W, const SceneHit& hit) {
  if (!shape.chequered) return shape.color;
  const Ray ray_G = move_ray(ray_W, X_WG);
  const Vector3d p = ray_G.p + hit.t * ray_G.d;
  const double square = std::floor(p.x() / kSquare) + std::floor(p.y() / kSquare);
  return std::fmod(std::abs(square), 2.0) == 0.0 ? shape.color : Vector3d(kDarkSquare * shape.color);
}

// Towards where it is seen from: triangles of a drawing have two sides.
Vector3d find_facing_normal(const Ray& ray_W, const SceneHit& hit) {
  return hit.n_W.dot(ray_W.d) > 0.0 ? -hit.n_W : hit.n_W;
}

}  // namespace

Vector3d get_sky_color() { return {0.53, 0.70, 0.90}; }

Vector3d calc_color(const VisibleShape& shape, const Transform& X_WG, const Ray& ray_W, const SceneHit& hit) {
  const double sun = std::max(0.0, find_facing_normal(ray_W, hit).dot(kSun_W));
  return (kAmbient + (1.0 - kAmbient) * sun) * find_surface_color(shape, X_WG, ray_W, hit);
}

double calc_intensity(const VisibleShape& shape, const Transform& X_WG, const Ray& ray_W, const SceneHit& hit) {
  const double cosine = std::abs(hit.n_W.dot(ray_W.d)) / ray_W.d.norm();
  return std::min(1.0, cosine * find_surface_color(shape, X_WG, ray_W, hit).mean());
}

}  // namespace hrp
