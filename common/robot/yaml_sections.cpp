// SPDX-License-Identifier: BSD-3-Clause
#include "common/robot/yaml_sections.h"

#include <sstream>

#include <yaml-cpp/yaml.h>

namespace hrp {
namespace {

bool is_mark(const std::string& line) {
  return line.rfind("---", 0) == 0 || line.rfind("...", 0) == 0 || line.rfind('%', 0) == 0;
}

// Lines that are indented, items, comments and closing brackets belong to the key before them.
bool begins_key(const std::string& line) {
  return !line.empty() && std::string(" -#\t\r]}),").find(line[0]) == std::string::npos;
}

}  // namespace

std::vector<YamlSection> split_sections(const std::string& text) {
  std::vector<YamlSection> sections(1);
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (is_mark(line)) continue;
    if (begins_key(line)) sections.push_back({line.substr(0, line.find(':')), ""});
    sections.back().text += line + "\n";
  }
  if (sections[0].text.empty()) sections.erase(sections.begin());
  return sections;
}

std::string list_items(const YamlSection& section, const std::string& text) {
  const size_t begin = section.text.find('\n') + 1;
  const std::string first = section.text.substr(section.text.find(':') + 1, begin);
  const bool alone = first.find_first_not_of(" \t\r") >= first.find_first_of("#\n");
  if (alone && section.text.compare(begin, 4, "  - ") == 0) return section.text.substr(begin);
  std::string lines;
  for (YAML::Node item : YAML::Load(text)[section.key]) {
    item.SetStyle(YAML::EmitterStyle::Flow);
    YAML::Emitter line;
    line << item;
    lines += std::string("  - ") + line.c_str() + "\n";
  }
  return lines;
}

}  // namespace hrp
