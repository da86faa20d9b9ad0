// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/multibody/model.h"

namespace hrp::test {

// Links of 1 kg in a chain, "link0" and on: joint i of the list moves link i + 1.
inline TreeSpec make_chain(const std::string& name, const std::vector<std::string>& joints) {
  TreeSpec tree;
  tree.name = name;
  for (size_t i = 0; i <= joints.size(); ++i) {
    LinkSpec link;
    link.name = "link" + std::to_string(i);
    link.parent = static_cast<int>(i) - 1;
    link.inertia.mass = 1.0;
    if (i > 0) link.joint.name = joints[i - 1];
    tree.links.push_back(link);
  }
  return tree;
}

}  // namespace hrp::test
