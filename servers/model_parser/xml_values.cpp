// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/xml_values.h"

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>

#include <tinyxml2.h>

namespace hrp {

std::vector<double> parse_numbers(const char* text, size_t count) {
  std::vector<double> numbers;
  std::istringstream words(text);
  std::string word;
  while (words >> word) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (end == word.c_str() || *end != '\0' || !std::isfinite(value)) return {};
    numbers.push_back(value);
  }
  return numbers.size() == count ? numbers : std::vector<double>();
}

std::string get_attribute(const tinyxml2::XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? "" : value;
}

}  // namespace hrp
