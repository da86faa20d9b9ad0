// SPDX-License-Identifier: BSD-3-Clause
#include <png.h>

#include <csetjmp>
#include <cstdio>

#include "common/base/diagnostics.h"
#include "common/robot/surface_file.h"

namespace hrp {
namespace {

void ignore_warning(png_structp, png_const_charp) {}

// libpng reports an error by longjmp: functions that call it hold nothing that needs a destructor.
struct PngReader {
  explicit PngReader(const std::string& path) : file(std::fopen(path.c_str(), "rb")) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, ignore_warning);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  ~PngReader() {
    png_destroy_read_struct(&png, &info, nullptr);
    if (file != nullptr) std::fclose(file);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  static void leave(png_structp png, png_const_charp) { png_longjmp(png, 1); }

  bool read_header() {
    if (file == nullptr || info == nullptr || setjmp(png_jmpbuf(png)) != 0) return false;
    png_init_io(png, file);
    png_read_info(png, info);
    return true;
  }
  bool read_rows(png_bytepp rows) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_packing(png);
    png_set_strip_alpha(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    png_read_image(png, rows);
    return true;
  }

  FILE* file = nullptr;
  png_structp png = nullptr;
  png_infop info = nullptr;
};

}  // namespace

HeightTable read_png(const std::string& path) {
  PngReader reader(path);
  if (!reader.read_header()) refuse_input(path, "is no PNG image");
  const size_t columns = png_get_image_width(reader.png, reader.info),
               rows = png_get_image_height(reader.png, reader.info);
  const int bits = png_get_bit_depth(reader.png, reader.info), colour = png_get_color_type(reader.png, reader.info);
  if (colour != PNG_COLOR_TYPE_GRAY && colour != PNG_COLOR_TYPE_GRAY_ALPHA)
    refuse_input(path, "is a coloured image, expected grey");
  if (columns * rows > static_cast<size_t>(kMostHeights)) {
    refuse_input(path, "has " + std::to_string(columns * rows) + " pixels, expected " + std::to_string(kMostHeights) +
                           " at most");
  }
  const size_t bytes = bits > 8 ? 2 : 1;
  std::vector<png_byte> pixels(columns * rows * bytes * 2);  // twice: alpha goes while rows are read
  std::vector<png_bytep> starts;
  for (size_t i = 0; i < rows; ++i) starts.push_back(pixels.data() + i * columns * bytes * 2);
  if (!reader.read_rows(starts.data())) refuse_input(path, "is a damaged PNG image");
  HeightTable table;
  table.columns = static_cast<int>(columns);
  table.rows = static_cast<int>(rows);
  table.white = static_cast<double>((1 << bits) - 1);
  for (const png_bytep row : starts) {
    for (size_t j = 0; j < columns; ++j) {
      table.values.push_back(bytes == 2 ? row[2 * j] * 256 + row[2 * j + 1] : row[j]);
    }
  }
  return table;
}

}  // namespace hrp
