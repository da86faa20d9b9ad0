// SPDX-License-Identifier: BSD-3-Clause
// Writes JSON of known shape, fast and without a library: a run needs none otherwise.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace hrp {

// Calls follow the text: begin(), key(), value, end(). Commas come by themselves.
class JsonText {
 public:
  void clear() { text_.clear(); }
  const std::string& text() const { return text_; }
  JsonText& begin(char bracket) {
    separate();
    text_ += bracket;
    return *this;
  }
  JsonText& end(char bracket) {
    text_ += bracket;
    return *this;
  }
  JsonText& key(const char* name) {
    separate();
    text_.append(1, '"').append(name).append("\":");
    return *this;
  }
  JsonText& put(const std::string& value) {
    separate();
    text_ += '"';
    for (const char c : value) put_character(c);
    text_ += '"';
    return *this;
  }
  JsonText& put(const char* value) { return put(std::string(value)); }
  // Nine digits: a nanometre in a metre. JSON has no word for what is not finite.
  JsonText& put(double value) {
    separate();
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.9g", value);
    text_ += std::isfinite(value) ? digits : "null";
    return *this;
  }
  JsonText& put(long value) {
    separate();
    text_ += std::to_string(value);
    return *this;
  }
  JsonText& put(bool value) {
    separate();
    text_ += value ? "true" : "false";
    return *this;
  }
  // JSON that is ready.
  JsonText& raw(const std::string& json) {
    separate();
    text_ += json;
    return *this;
  }

 private:
  void separate() {
    if (text_.empty()) return;
    const char last = text_.back();
    if (last != '{' && last != '[' && last != ':') text_ += ',';
  }
  void put_character(char c) {
    if (c == '"' || c == '\\') {
      text_.append(1, '\\').append(1, c);
    } else if (static_cast<unsigned char>(c) >= 0x20) {
      text_ += c;
    } else {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(c)));
      text_ += code;
    }
  }
  std::string text_;
};

}  // namespace hrp
