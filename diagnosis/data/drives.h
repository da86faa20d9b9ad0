// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// True if some joint has a drive.
inline bool has_drive(const TreeSpec& tree) {
  return std::any_of(tree.links.begin() + 1, tree.links.end(),
                     [](const LinkSpec& link) { return link.joint.actuated; });
}

}  // namespace hrp::diagnosis
