// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace hrp {

// "a, b, c": what `say` says of each item.
template <class List, class Say>
std::string join_words(const List& list, const Say& say, const char* between = ", ") {
  std::string text;
  for (const auto& item : list) text += (text.empty() ? "" : between) + say(item);
  return text;
}

template <class Words>
std::string join_words(const Words& words) {
  return join_words(words, [](const std::string& word) { return word; });
}

}  // namespace hrp
