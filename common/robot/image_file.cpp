// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/image_file.h"

#include <png.h>

#include "common/base/check.h"
#include "common/base/diagnostics.h"

namespace hrp {
namespace {

void write(const std::string& path, int width, int height, png_uint_32 format, const void* pixels) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = format;
  if (png_image_write_to_file(&image, path.c_str(), 0, pixels, 0, nullptr) != 0) return;
  refuse_input(path, std::string("cannot be written: ") + image.message);
}

}  // namespace

void write_color_png(const std::string& path, int width, int height, const std::vector<uint8_t>& rgb) {
  HRP_CHECK(rgb.size() == 3 * static_cast<size_t>(width) * static_cast<size_t>(height), rgb.size() << " bytes");
  write(path, width, height, PNG_FORMAT_RGB, rgb.data());
}

void write_grey_png(const std::string& path, int width, int height, const std::vector<uint16_t>& values) {
  HRP_CHECK(values.size() == static_cast<size_t>(width) * static_cast<size_t>(height), values.size() << " values");
  write(path, width, height, PNG_FORMAT_LINEAR_Y, values.data());
}

}  // namespace hrp
