// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tinyxml2 {
class XMLDocument;
class XMLElement;
}  // namespace tinyxml2

namespace hrp {

class Diagnostics;

// `count` finite numbers with blanks between them; empty when the text is anything else.
std::vector<double> parse_numbers(const char* text, size_t count);

// Empty where the element has no such attribute.
std::string get_attribute(const tinyxml2::XMLElement& element, const char* name);

// Why `document` could not be parsed from `text`, with the line: the encoding, as UTF-16, or what the parser says.
void add_xml_error(const tinyxml2::XMLDocument& document, const std::string& text, const std::string& file,
                   Diagnostics* diagnostics);

}  // namespace hrp
