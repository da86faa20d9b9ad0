// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/foot_columns.h"

#include <algorithm>
#include <initializer_list>

#include "common/base/has.h"
#include "diagnosis/draft/column_names.h"

namespace hrp::diagnosis {
namespace {

const std::initializer_list<const char*> kForces{"force", "forces", "grf", "fsr", "fx", "fy", "fz"};
const std::initializer_list<const char*> kNamesOfFeet{"foot", "sole", "toe"};
const std::initializer_list<const char*> kFeet{"foot", "feet", "sole", "toe", "contact", "ground", "x", "y", "z"};

bool is_end(const TreeSpec& tree, size_t link) {
  return link > 0 && std::none_of(tree.links.begin(), tree.links.end(),
                                  [&](const LinkSpec& l) { return l.parent == static_cast<int>(link); });
}

bool has_all(const std::vector<std::string>& words, const std::vector<std::string>& asked) {
  return std::all_of(asked.begin(), asked.end(), [&](const std::string& word) { return has(words, word); });
}

// The only URDF link at the end of a chain that has these words, of several the only one that is a foot by its name.
// Empty if none.
std::string find_foot(const TreeSpec& tree, const std::vector<std::string>& asked) {
  std::vector<std::string> ends, feet;
  for (const FrameSpec& frame : tree.frames) {
    const std::vector<std::string> words = split_words(frame.name);
    if (!is_end(tree, static_cast<size_t>(frame.link)) || !has_all(words, asked)) continue;
    ends.push_back(frame.name);
    if (std::any_of(words.begin(), words.end(), [](const std::string& w) { return has(kNamesOfFeet, w); }))
      feet.push_back(frame.name);
  }
  return feet.size() == 1 ? feet[0] : ends.size() == 1 ? ends[0] : "";
}

}  // namespace

std::vector<FootColumn> find_foot_columns(const std::vector<std::string>& columns, const TreeSpec& tree) {
  std::vector<FootColumn> found;
  for (size_t i = 0; i < columns.size(); ++i) {
    std::vector<std::string> asked;
    bool force = false;
    std::string axis = "z";
    for (const std::string& word : split_words(columns[i])) {
      force = force || has(kForces, word);
      if (word == "x" || word == "y" || word == "fx" || word == "fy") axis = word.back();
      if (!has(kForces, word) && !has(kFeet, word)) asked.push_back(word);
    }
    const std::string link = force && !asked.empty() ? find_foot(tree, asked) : "";
    if (!link.empty()) found.push_back({i, link, axis});
  }
  return found;
}

}  // namespace hrp::diagnosis
