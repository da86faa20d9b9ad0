// SPDX-License-Identifier: BSD-3-Clause
// PNG images of what cameras see.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hrp {

// Rows from the top, pixels from the left. Both throw InputError naming a file that cannot be written.
void write_color_png(const std::string& path, int width, int height, const std::vector<uint8_t>& rgb);
void write_grey_png(const std::string& path, int width, int height, const std::vector<uint16_t>& values);

}  // namespace hrp
