// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// Text for XML and HTML, between tags and in quotes of either kind. Control characters are left out, as XML has none
// but line feeds and tabs.
inline std::string escape_xml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

}  // namespace hrp
