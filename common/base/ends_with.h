// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

inline bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace hrp
