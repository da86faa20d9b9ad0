// SPDX-License-Identifier: BSD-3-Clause
// Numbers in texts.
#pragma once

#include <string>

namespace hrp::diagnosis {

// A short text (up to 120 characters) with up to three numbers, by printf's pattern.
std::string format(const char* pattern, double a, double b = 0.0, double c = 0.0);

}  // namespace hrp::diagnosis
