// SPDX-License-Identifier: BSD-3-Clause
// Pictures of cameras and scans of lidars as the viewer takes them from anybody: bit 0 of the first byte chooses which.
#include <cstdlib>

#include "servers/viewer/picture_message.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 1) return 0;
  const hrp::Bytes sample{data + 1, size - 1};
  try {
    const hrp::Picture picture = data[0] % 2 == 0 ? hrp::read_picture(sample) : hrp::read_scan(sample);
    const size_t each = picture.kind == hrp::Picture::Kind::kColor   ? 3
                        : picture.kind == hrp::Picture::Kind::kDepth ? 4
                                                                     : 12;
    // The page reads as many.
    if (picture.pixels.size() != each * picture.width * picture.height) std::abort();
    hrp::make_picture_message(0, "topic", picture);
  } catch (const hrp::PictureError&) {
    // Said in the panel.
  }
  return 0;
}
