// SPDX-License-Identifier: BSD-3-Clause
// Our <loop> element of a URDF: a joint that closes a chain, which URDF's tree cannot say. Other readers skip it.
//
//   <loop name="left_outer_rod" type="ball">
//     <frame_a link="L_OUTER_ROD"><origin xyz="0 0 -0.2" rpy="0 0 0"/></frame_a>
//     <frame_b link="L_FOOT"><origin xyz="-0.05 0.03 0"/></frame_b>
//   </loop>
//
// type: ball (origins stay together), pin (and their z axes), weld (and all axes); URDF's and others' words for them,
// too.
#pragma once

#include <vector>

#include "common/base/diagnostics.h"
#include "common/robot/scenario.h"

namespace tinyxml2 {
class XMLElement;
}

namespace hrp {

struct UrdfScan;

struct LoopScan {
  LoopSpec spec;
  int line = 0;
};

// All <loop> right below <robot>. `scan` has the file's name and all links. Adds errors to `diagnostics`.
std::vector<LoopScan> scan_loops(const tinyxml2::XMLElement& robot, const UrdfScan& scan, Diagnostics* diagnostics);

}  // namespace hrp
