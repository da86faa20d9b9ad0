// SPDX-License-Identifier: BSD-3-Clause
// The text of a scenario by its top-level keys, with its comments and its layout: for scenarios that are written anew
// from an old one.
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct YamlSection {
  std::string key;   // empty: what stands before the first one
  std::string text;  // all lines, with that of the key
};

// Marks of documents ("---", "...") and directives ("%YAML 1.2") are left out: a text has one document.
std::vector<YamlSection> split_sections(const std::string& text);

// The items of a section of `text` that is a list, as lines that begin with "  - ": further ones can follow, whatever
// the layout was. The text was read before: the section alone may name anchors of others.
std::string list_items(const YamlSection& section, const std::string& text);

}  // namespace hrp
