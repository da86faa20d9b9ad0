// SPDX-License-Identifier: BSD-3-Clause
#include "common/plot/svg_text.h"

#include <array>
#include <cstdarg>
#include <cstdio>

namespace hrp::plot {

std::string format(const char* pattern, ...) {
  std::array<char, 512> text;
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, arguments);
  va_end(arguments);
  return text.data();
}

}  // namespace hrp::plot
