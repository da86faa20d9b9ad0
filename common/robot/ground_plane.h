// SPDX-License-Identifier: BSD-3-Clause
// The plane that a robot stands on.
#pragma once

#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

// A plane with the robot on the side of its normal.
struct GroundPlane {
  Vector3d n_W = Vector3d::UnitZ();
  double offset = 0.0;  // [m] points of the plane have n . p = offset
  double margin = 0.0;  // [m] points of a sole this far above are of interest, too
  bool present = true;  // else robots stand on obstacles
};

// The ground of the scenario: turned by roll, then pitch about world axes, around the point (0, 0, height).
GroundPlane make_ground_plane(const GroundSpec& ground);

// Whether what touches stands on the ground: on the plane, or on obstacles where there is none.
inline bool is_ground_pair(const PairForce& pair, const GroundPlane& ground) {
  if (is_object(pair.body_a)) return false;
  return ground.present ? pair.body_b == kGround : pair.body_b < 0;
}

}  // namespace hrp
