// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/model/link_reach.h"

#include <algorithm>

namespace hrp::diagnosis {

double calc_link_reach(const TreeSpec& tree, int link) {
  double reach = tree.links[static_cast<size_t>(link)].inertia.p_LLcm_L.norm();
  for (const LinkSpec& l : tree.links) {
    if (l.parent == link) reach = std::max(reach, l.joint.X_PF.p.norm());
  }
  for (const FrameSpec& frame : tree.frames) {
    if (frame.link == link) reach = std::max(reach, frame.X_LF.p.norm());
  }
  return 0.1 + 2.0 * reach;
}

double calc_carried_reach(const TreeSpec& tree, int link) { return calc_link_reach(tree, link) + 0.5; }

}  // namespace hrp::diagnosis
