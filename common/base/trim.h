// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// Without white space at both ends.
inline std::string trim(const std::string& text) {
  const char* const kWhite = " \t\r\n";
  const size_t first = text.find_first_not_of(kWhite);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(kWhite) - first + 1);
}

}  // namespace hrp
