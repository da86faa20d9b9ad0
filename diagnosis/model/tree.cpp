// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/tree.h"

#include <algorithm>

namespace hrp::diagnosis {

bool is_above(const TreeSpec& tree, int link, int carried) {
  for (int l = carried; l >= 0; l = tree.links[static_cast<size_t>(l)].parent) {
    if (l == link) return true;
  }
  return false;
}

bool is_last(const TreeSpec& tree, int link) {
  return std::none_of(tree.links.begin(), tree.links.end(),
                      [&](const LinkSpec& other) { return other.parent == link; });
}

}  // namespace hrp::diagnosis
