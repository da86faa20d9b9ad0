// SPDX-License-Identifier: BSD-3-Clause
// Colours: red, green, blue, 0 to 1.
#pragma once

#include "servers/vision/embree/ray_caster.h"

namespace hrp {

// Where nothing is seen.
Vector3d get_sky_color();
// Share of the light from the sun's direction that a surface sends back to every side (Lambert): color times what is
// left on the shaded side, plus the cosine of the sun's angle with the normal. The sun is fixed to the world.
Vector3d calc_color(const VisibleShape& shape, const Transform& X_WG, const Ray& ray_W, const SceneHit& hit);
// Intensity of a lidar's return, 0 to 1: brightness of the surface times the cosine of the ray with the normal.
double calc_intensity(const VisibleShape& shape, const Transform& X_WG, const Ray& ray_W, const SceneHit& hit);

}  // namespace hrp
