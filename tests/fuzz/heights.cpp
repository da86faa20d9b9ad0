// SPDX-License-Identifier: BSD-3-Clause
// Height fields of obstacles: the first byte chooses .csv, .pgm or .png. A PNG gets right checksums, or hardly one
// would be read.
#include <zlib.h>

#include <cstdlib>
#include <string>

#include "common/base/diagnostics.h"
#include "common/robot/surface_file.h"
#include "tests/fuzz/fuzz.h"

namespace {

constexpr const char* kEndings[] = {".csv", ".pgm", ".png"};

uint32_t read_big_endian(const std::string& text, size_t at) {
  uint32_t value = 0;
  for (size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<unsigned char>(text[at + k]);
  return value;
}

// A chunk: length of its data, four letters, data, CRC of letters and data.
void mend_checksums(std::string* png) {
  for (size_t at = 8; at + 12 <= png->size();) {
    const size_t length = read_big_endian(*png, at);
    if (length > png->size() - at - 12) return;
    const auto* letters = reinterpret_cast<const Bytef*>(png->data() + at + 4);
    const uLong sum = crc32(0, letters, static_cast<uInt>(length + 4));
    for (size_t k = 0; k < 4; ++k) (*png)[at + 8 + length + k] = static_cast<char>(sum >> (24 - 8 * k));
    at += 12 + length;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  const size_t kind = data[0] % 3;
  std::string text = hrp::test::make_text(data + 1, size - 1);
  if (kind == 2) mend_checksums(&text);
  const hrp::test::MemoryFile file(reinterpret_cast<const uint8_t*>(text.data()), text.size(), kEndings[kind]);
  hrp::ObstacleSpec obstacle;
  obstacle.shape = "height_field";
  obstacle.file = file.path();
  obstacle.spacing = 0.1;
  if (kind > 0) {
    obstacle.low = -0.2;
    obstacle.high = 0.3;
  }
  try {
    const auto surface = hrp::load_surface(obstacle);
    const auto heights = static_cast<size_t>(surface->columns) * static_cast<size_t>(surface->rows);
    if (surface->heights.size() != heights) std::abort();
    // Two for each square.
    const auto squares = static_cast<size_t>(surface->columns - 1) * static_cast<size_t>(surface->rows - 1);
    if (hrp::make_triangles(*surface).triangles.size() != 2 * squares) std::abort();
  } catch (const hrp::InputError&) {
  }
  return 0;
}
