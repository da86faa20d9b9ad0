// SPDX-License-Identifier: BSD-3-Clause
// A lidar: rays at even angles, all of one instant.
#pragma once

#include <vector>

#include "servers/vision/camera.h"

namespace hrp {

// Of the lidar's frame: x forward, y left, z up. A unit vector.
Vector3d calc_lidar_direction(const LidarSpec& lidar, int row, int column);

// x, y, z [m] in the lidar's frame and intensity of each ray, row by row; all four NaN where nothing is within range.
using Points = std::vector<float>;
constexpr size_t kNumbersPerPoint = 4;

// X_WC: the lidar's frame. `caster` has the shapes where they are in `world`.
void take_scan(const LidarSpec& lidar, const Transform& X_WC, const VisibleWorld& world, const RayCaster& caster,
               const NoiseKey& noise, Points* points);

}  // namespace hrp
