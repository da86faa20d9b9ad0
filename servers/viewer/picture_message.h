// SPDX-License-Identifier: BSD-3-Clause
// A camera's picture or a lidar's scan as pages get it.
#pragma once

#include <cstdint>
#include <string>

#include "common/messages/picture.h"

namespace hrp {

// A page draws no more than this of a picture (0.9 MB of colour, 1.2 MB of depth) or a scan.
constexpr uint64_t kMostPagePixels = 640 * 480, kMostPagePoints = 100000;

// The binary message that a page gets (docs/viewer.md): 4 bytes with the length of a JSON text, the text, the pixels.
std::string make_picture_message(size_t source, const std::string& topic, const Picture& picture);
// The same without pixels: why there are none.
std::string make_picture_message(size_t source, const std::string& topic, const std::string& error);

}  // namespace hrp
