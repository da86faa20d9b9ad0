// SPDX-License-Identifier: BSD-3-Clause
#include "controller/motion/motion_text.h"

#include <charconv>
#include <cmath>

namespace hrp {

bool read_number(const char** at, const char* end, double* value) {
  const char* p = *at;
  while (p < end && (*p == ' ' || *p == '\t' || *p == '\r' || *p == '\n')) ++p;
  if (p < end && *p == '+') ++p;
  const std::from_chars_result result = std::from_chars(p, end, *value);
  if (result.ec != std::errc() || !std::isfinite(*value)) return false;
  *at = result.ptr;
  return true;
}

std::string show_word(const char* at, const char* end) {
  while (at < end && *at == ' ') ++at;
  const char* stop = at;
  while (stop < end && stop - at < 40 && *stop != ',' && *stop != ']' && *stop != '\n' && *stop != '\r') ++stop;
  return "'" + std::string(at, stop) + "'";
}

}  // namespace hrp
