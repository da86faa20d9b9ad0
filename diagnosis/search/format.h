// SPDX-License-Identifier: BSD-3-Clause
// Formats numbers in texts.
#pragma once

#include <string>

namespace hrp::diagnosis {

// Formats up to three numbers by a printf pattern; at most 119 characters.
std::string format(const char* pattern, double a, double b = 0.0, double c = 0.0);

}  // namespace hrp::diagnosis
