// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/format.h"

#include <cstdio>

namespace hrp::diagnosis {

std::string format(const char* pattern, double a, double b, double c) {
  char text[120];
  std::snprintf(text, sizeof text, pattern, a, b, c);
  return text;
}

}  // namespace hrp::diagnosis
