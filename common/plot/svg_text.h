// SPDX-License-Identifier: BSD-3-Clause
// Text of SVG files.
#pragma once

#include <string>

namespace hrp::plot {

// As printf; 511 characters at most.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

}  // namespace hrp::plot
