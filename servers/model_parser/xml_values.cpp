// SPDX-License-Identifier: BSD-3-Clause
#include "servers/model_parser/xml_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>

#include <tinyxml2.h>

#include "common/base/diagnostics.h"
#include "common/base/printable.h"

namespace hrp {

namespace {

// The whole word as a finite number, with a point whatever the locale; empty if it is none.
std::optional<double> parse_number(const std::string& word) {
  const char *begin = word.data() + (word[0] == '+' ? 1 : 0), *end = word.data() + word.size();
  double value = 0.0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::vector<double> parse_numbers(const char* text, size_t count) {
  std::vector<double> numbers;
  std::istringstream words(text);
  std::string word;
  while (words >> word) {
    const std::optional<double> value = parse_number(word);
    if (!value) return {};
    numbers.push_back(*value);
  }
  return numbers.size() == count ? numbers : std::vector<double>();
}

std::string get_attribute(const tinyxml2::XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? "" : value;
}

void add_xml_error(const tinyxml2::XMLDocument& document, const std::string& text, const std::string& file,
                   Diagnostics* diagnostics) {
  const size_t at = find_strange_byte(text);
  if (at != std::string::npos) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
    return diagnostics->add_error({file, "", static_cast<int>(line)},
                                  "not valid XML: " + describe_strange_byte(text, at));
  }
  if (document.ErrorID() == tinyxml2::XML_ERROR_EMPTY_DOCUMENT)
    return diagnostics->add_error({file, "", 1}, "is empty: expected a robot");
  std::string reason = document.ErrorStr() == nullptr ? "" : document.ErrorStr();
  const size_t cut = reason.find("ErrorID=");
  if (cut != std::string::npos && reason.find(": ", cut) != std::string::npos) {
    reason = reason.substr(reason.rfind("XML_") == std::string::npos ? 0 : reason.find("XML_"));
  }
  diagnostics->add_error({file, "", document.ErrorLineNum()}, "not valid XML: " + reason);
}

}  // namespace hrp
