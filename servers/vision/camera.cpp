// SPDX-License-Identifier: BSD-3-Clause
#include "servers/vision/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/noise.h"
#include "servers/vision/shading.h"

namespace hrp {
namespace {

// Beyond the channels of all other sensors, which number theirs below 2^40.
constexpr int kSensorShift = 40;

constexpr int kReadings = 4;  // of a pixel: red, green, blue, depth

uint8_t make_byte(double value) { return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255.0)); }

void write_color(Vector3d color, double noise, const NoiseKey& key, unsigned long long reading, uint8_t* rgb) {
  for (int k = 0; k < 3; ++k) {
    if (noise > 0.0) color[k] += noise * key.calc(reading + static_cast<unsigned long long>(k));
    rgb[k] = make_byte(color[k]);
  }
}

}  // namespace

double NoiseKey::calc(unsigned long long value) const {
  return calc_noise(seed, ((sensor + 1) << kSensorShift) + value, step);
}

Pinhole make_pinhole(const CameraSpec& camera) {
  return {0.5 * camera.width / std::tan(0.5 * camera.fov), 0.5 * (camera.width - 1), 0.5 * (camera.height - 1)};
}

Vector3d calc_pixel_direction(const Pinhole& pinhole, double u, double v) {
  return {(u - pinhole.cx) / pinhole.f, (v - pinhole.cy) / pinhole.f, 1.0};
}

void take_picture(const CameraSpec& camera, const Transform& X_WO, const VisibleWorld& world, const RayCaster& caster,
                  const NoiseKey& noise, CameraPicture* picture) {
  const Pinhole pinhole = make_pinhole(camera);
  const size_t pixels = static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height);
  picture->rgb.resize(camera.color ? 3 * pixels : 0);
  picture->depth.resize(camera.depth ? pixels : 0);
  size_t pixel = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++pixel) {
      const Ray ray{X_WO.p, X_WO.R * calc_pixel_direction(pinhole, u, v), camera.near, camera.far};
      const auto hit = caster.cast(ray);
      const unsigned long long reading = kReadings * pixel;
      if (camera.color) {
        const Vector3d color =
            hit ? calc_color(world.shapes()[hit->shape], world.poses()[hit->shape], ray, *hit) : get_sky_color();
        write_color(color, camera.color_noise, noise, reading, &picture->rgb[3 * pixel]);
      }
      if (!camera.depth) continue;
      double depth = hit ? hit->t : std::numeric_limits<double>::infinity();
      if (camera.depth_noise > 0.0 && hit) depth = std::max(0.0, depth + camera.depth_noise * noise.calc(reading + 3));
      picture->depth[pixel] = static_cast<float>(depth);
    }
  }
}

}  // namespace hrp
