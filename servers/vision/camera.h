// SPDX-License-Identifier: BSD-3-Clause
// A pinhole camera: one ray a pixel, through its middle.
#pragma once

#include <cstdint>
#include <vector>

#include "common/robot/vision_spec.h"
#include "servers/vision/embree/ray_caster.h"

namespace hrp {

// Pixel (u, v) counts columns from the left and rows from the top; its middle is at the whole numbers. A point p in the
// optical frame is seen at u = cx + f p.x / p.z, v = cy + f p.y / p.z.
struct Pinhole {
  double f = 1.0;             // [pixels]
  double cx = 0.0, cy = 0.0;  // [pixels]
};

Pinhole make_pinhole(const CameraSpec& camera);
// Along the middle of a pixel, with z = 1, so that t of a Ray is the depth [m].
Vector3d calc_pixel_direction(const Pinhole& pinhole, double u, double v);

// Row by row from the top.
struct CameraPicture {
  std::vector<uint8_t> rgb;  // three a pixel; empty for a camera without color
  std::vector<float> depth;  // [m] along the optical axis, +inf where nothing is seen; empty for a camera without depth
};

// Which random numbers a sensor's noise takes.
struct NoiseKey {
  unsigned long long seed = 1, sensor = 0, step = 0;
  // Standard normal; `value` numbers the readings of a picture.
  double calc(unsigned long long value) const;
};

// X_WO: optical frame. `caster` has the shapes where they are in `world`.
void take_picture(const CameraSpec& camera, const Transform& X_WO, const VisibleWorld& world, const RayCaster& caster,
                  const NoiseKey& noise, CameraPicture* picture);

}  // namespace hrp
