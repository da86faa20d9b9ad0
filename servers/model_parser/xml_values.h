// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tinyxml2 {
class XMLElement;
}

namespace hrp {

// `count` finite numbers with blanks between them; empty when the text is anything else.
std::vector<double> parse_numbers(const char* text, size_t count);

// Empty where the element has no such attribute.
std::string get_attribute(const tinyxml2::XMLElement& element, const char* name);

}  // namespace hrp
