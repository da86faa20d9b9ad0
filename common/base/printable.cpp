// SPDX-License-Identifier: BSD-3-Clause
#include "common/base/printable.h"

namespace hrp {
namespace {

// C0 and DEL; C1 (U+0080 to U+009F) as UTF-8 has it: 0xc2 and one more byte. U+009B begins sequences like ESC [.
bool is_control(const std::string& text, size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  if (byte < 0x20 || byte == 0x7f) return true;
  return byte == 0xc2 && at + 1 < text.size() && static_cast<unsigned char>(text[at + 1]) < 0xa0;
}

void append_code(unsigned char byte, std::string* out) {
  static const char kDigits[] = "0123456789abcdef";
  *out += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
}

std::string escape(const std::string& text, const char* kept) {
  std::string out;
  out.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (!is_control(text, i) || std::string(kept).find(text[i]) != std::string::npos) {
      out += text[i];
      continue;
    }
    append_code(byte, &out);
    if (byte == 0xc2) append_code(static_cast<unsigned char>(text[++i]), &out);
  }
  return out;
}

}  // namespace

std::string make_printable(const std::string& text) { return escape(text, "\n\t"); }

std::string make_printable_line(const std::string& text) { return escape(text, "\t"); }

size_t find_strange_byte(const std::string& text) {
  for (size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const size_t length = first < 0x80                    ? 1
                          : first >= 0xc2 && first < 0xe0 ? 2
                          : first >= 0xe0 && first < 0xf0 ? 3
                          : first >= 0xf0 && first < 0xf5 ? 4
                                                          : 0;
    if (length == 0 || i + length > text.size()) return i;
    for (size_t k = 1; k < length; ++k) {
      if ((static_cast<unsigned char>(text[i + k]) & 0xc0) != 0x80) return i;
    }
    const auto second = length > 2 ? static_cast<unsigned char>(text[i + 1]) : 0;
    // Longer than need be, halves of UTF-16, beyond U+10FFFF.
    const bool odd = (first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) ||
                     (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90);
    if (odd) return i;
    i += length;
  }
  return std::string::npos;
}

std::string describe_strange_byte(const std::string& text, size_t at) {
  return "byte " + std::to_string(static_cast<unsigned char>(text[at])) + " is not UTF-8; expected a text in UTF-8";
}

}  // namespace hrp
