// SPDX-License-Identifier: BSD-3-Clause
// Names of others as YAML takes them: "hip: left" would be a mapping, "#1" a comment.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>

namespace hrp::diagnosis {

inline std::string quote(std::string text) {
  for (size_t at = 0; (at = text.find('\'', at)) != std::string::npos; at += 2) text.insert(at, "'");
  return "'" + text + "'";
}

// As it is where YAML takes it as a word.
inline std::string quote_name(const std::string& name) {
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '/' || c == '-';
  });
  return plain ? name : quote(name);
}

}  // namespace hrp::diagnosis
