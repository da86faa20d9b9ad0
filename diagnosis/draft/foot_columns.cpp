// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/draft/foot_columns.h"

#include <algorithm>
#include <initializer_list>

#include "common/base/has.h"
#include "diagnosis/draft/column_names.h"

namespace hrp::diagnosis {
namespace {

const std::initializer_list<const char*> kForces{"force", "forces", "grf", "fsr", "fx", "fy", "fz"};
const std::initializer_list<const char*> kNamesOfFeet{"foot", "feet", "sole", "toe"};
const std::initializer_list<const char*> kFeet{"foot", "feet", "sole", "toe", "contact", "ground", "x", "y", "z"};

// "right" of a log and "R" of a model are one side.
std::vector<std::string> split_sides(const std::string& name) {
  std::vector<std::string> words = split_words(name);
  for (std::string& word : words) {
    if (word == "left" || word == "right") word.resize(1);
  }
  return words;
}

bool is_foot(const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [](const std::string& w) { return has(kNamesOfFeet, w); });
}

bool is_end(const TreeSpec& tree, size_t link) {
  return link > 0 && std::none_of(tree.links.begin(), tree.links.end(),
                                  [&](const LinkSpec& l) { return l.parent == static_cast<int>(link); });
}

bool has_all(const std::vector<std::string>& words, const std::vector<std::string>& asked) {
  return std::all_of(asked.begin(), asked.end(), [&](const std::string& word) { return has(words, word); });
}

// The only URDF link at the end of a chain that has these words; of several, the one that is a foot by its name, or the
// first of those that are fixed to each other. Empty if none.
std::string find_foot(const TreeSpec& tree, const std::vector<std::string>& asked) {
  std::vector<const FrameSpec*> ends, feet;
  for (const FrameSpec& frame : tree.frames) {
    const std::vector<std::string> words = split_sides(frame.name);
    if (!is_end(tree, static_cast<size_t>(frame.link)) || !has_all(words, asked)) continue;
    ends.push_back(&frame);
    if (is_foot(words)) feet.push_back(&frame);
  }
  const bool one = !feet.empty() &&
                   std::all_of(feet.begin(), feet.end(), [&](const FrameSpec* f) { return f->link == feet[0]->link; });
  return one ? feet[0]->name : ends.size() == 1 ? ends[0]->name : "";
}

}  // namespace

std::vector<FootColumn> find_foot_columns(const std::vector<std::string>& columns, const TreeSpec& tree) {
  std::vector<FootColumn> found;
  for (size_t i = 0; i < columns.size(); ++i) {
    std::vector<std::string> asked;
    bool force = false;
    std::string axis = "z";
    const std::vector<std::string> words = split_sides(columns[i]);
    for (const std::string& word : words) {
      force = force || has(kForces, word);
      if (word == "x" || word == "y" || word == "fx" || word == "fy") axis = word.back();
      if (!has(kForces, word) && !has(kFeet, word)) asked.push_back(word);
    }
    const std::string link = force && !asked.empty() ? find_foot(tree, asked) : "";
    if (!link.empty()) found.push_back({i, link, axis, is_foot(words) || is_foot(split_sides(link))});
  }
  return found;
}

}  // namespace hrp::diagnosis
