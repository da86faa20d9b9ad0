// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdlib>
#include <string>

namespace hrp {

// A check for options of CLI11 that hold numbers: CLI::Range lets nan pass, as no comparison with it is true.
inline std::string refuse_nan(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? "Value " + text + " is no number" : "";
}

}  // namespace hrp
