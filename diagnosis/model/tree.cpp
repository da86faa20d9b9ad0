// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis {

bool is_above(const TreeSpec& tree, int link, int carried) {
  for (int l = carried; l >= 0; l = tree.links[static_cast<size_t>(l)].parent) {
    if (l == link) return true;
  }
  return false;
}

}  // namespace hrp::diagnosis
