// SPDX-License-Identifier: BSD-3-Clause
#include "common/multibody/tree_spec.h"

namespace hrp {

int TreeSpec::find_link(const std::string& name) const {
  for (size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

int TreeSpec::find_joint(const std::string& name) const {
  for (int i = 0; i < num_joints(); ++i) {
    if (joint(i).name == name) return i;
  }
  return -1;
}

int TreeSpec::find_frame(const std::string& name) const {
  for (size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace hrp
