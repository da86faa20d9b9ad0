// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/lidar.h"

#include <cmath>
#include <limits>

#include "servers/vision/shading.h"

namespace hrp {
namespace {

// The middle of part k of `count` even ones.
double find_middle(double first, double last, int k, int count) { return first + (last - first) * (k + 0.5) / count; }

}  // namespace

Vector3d calc_lidar_direction(const LidarSpec& lidar, int row, int column) {
  const double azimuth = find_middle(lidar.first_azimuth, lidar.last_azimuth, column, lidar.columns);
  const double elevation = find_middle(lidar.first_elevation, lidar.last_elevation, row, lidar.rows);
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

void take_scan(const LidarSpec& lidar, const Transform& X_WC, const VisibleWorld& world, const RayCaster& caster,
               const NoiseKey& noise, Points* points) {
  points->clear();
  points->reserve(kNumbersPerPoint * static_cast<size_t>(lidar.rows) * static_cast<size_t>(lidar.columns));
  unsigned long long reading = 0;
  for (int row = 0; row < lidar.rows; ++row) {
    for (int column = 0; column < lidar.columns; ++column, ++reading) {
      const Vector3d direction = calc_lidar_direction(lidar, row, column);
      const Ray ray{X_WC.p, X_WC.R * direction, lidar.min_range, lidar.max_range};
      const auto hit = caster.cast(ray);
      if (!hit) {
        points->insert(points->end(), kNumbersPerPoint, std::numeric_limits<float>::quiet_NaN());
        continue;
      }
      const double range = hit->t + (lidar.noise > 0.0 ? lidar.noise * noise.calc(reading) : 0.0);
      for (int k = 0; k < 3; ++k) points->push_back(static_cast<float>(range * direction[k]));
      points->push_back(
          static_cast<float>(calc_intensity(world.shapes()[hit->shape], world.poses()[hit->shape], ray, *hit)));
    }
  }
}

}  // namespace hrp
