// SPDX-License-Identifier: BSD-3-Clause
// A camera's picture or a lidar's scan as pages draw it, made of a sample of its topic. Anybody may publish one, so nothing in
// it is believed before it is checked.
#pragma once

#include <stdexcept>
#include <string>

#include "common/bus/bus.h"

namespace hrp {

// A picture that makes no sense; the text names field, value and what was expected.
class PictureError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct PagePicture {
  enum class Kind {
    kColor,  // red, green, blue: a byte each
    kDepth,  // [m] in single precision, little endian; infinite: nothing is seen
    kPoints  // x, y, z [m] in the lidar's frame, each as depth is; one row of points that were seen
  };
  Kind kind = Kind::kColor;
  double time = 0.0;             // [s] of its stamp
  uint32_t width = 0, height = 0;  // [pixels]
  std::string pixels;            // rows from the top
  uint32_t stride = 1;           // of a large picture only every n-th pixel of every n-th row is here
};

// Of a sensor_msgs/Image. Throws PictureError, also for bytes that are no such sample.
PagePicture read_picture(Bytes sample);
// The same of a sensor_msgs/PointCloud2.
PagePicture read_scan(Bytes sample);

// The binary message that a page gets (docs/viewer.md): 4 bytes with the length of a JSON text, the text, the pixels.
std::string make_picture_message(size_t source, const std::string& topic, const PagePicture& picture);
// The same without pixels: why there are none.
std::string make_picture_message(size_t source, const std::string& topic, const std::string& error);

}  // namespace hrp
