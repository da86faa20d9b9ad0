// SPDX-License-Identifier: BSD-3-Clause
// A camera's picture or a lidar's scan from a sample of its topic, in few formats. Anybody may publish one, so nothing
// in it is believed before it is checked.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "common/bus/bus.h"

namespace hrp {

// A picture that makes no sense; the text names field, value and what was expected.
class PictureError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Picture {
  enum class Kind {
    kColor,  // red, green, blue: a byte each
    kDepth,  // [m] in single precision, little endian; infinite: nothing is seen
    kPoints  // x, y, z [m] in the lidar's frame, each as depth is; one row of points that were seen
  };
  Kind kind = Kind::kColor;
  double time = 0.0;               // [s] of its stamp
  uint32_t width = 0, height = 0;  // [pixels]
  std::string pixels;              // rows from the top
  uint32_t stride = 1;             // of a large picture only every n-th pixel of every n-th row is here
};

// Of a sensor_msgs/Image, with at most so many pixels. Throws PictureError, also for bytes that are no such sample.
Picture read_picture(Bytes sample, uint64_t most_pixels = UINT64_MAX);
// The same of a sensor_msgs/PointCloud2.
Picture read_scan(Bytes sample, uint64_t most_points = UINT64_MAX);

}  // namespace hrp
