// SPDX-License-Identifier: BSD-3-Clause
// Memory of sticking points. Beyond [H03]: the damper of eq. (5) alone lets a robot creep; here every point remembers
// how far it has been displaced since it stuck, and a spring pulls it back. Sliding carries the anchor along, so that
// the spring never holds more than the friction cone allows.
#pragma once

#include <vector>

#include "common/spatial/transform.h"

namespace hrp {

struct ContactAnchor {
  int body_a = 0;
  int body_b = 0;
  Vector3d p_A = Vector3d::Zero();     // [m] the point in A: by it the point is found again in the next step
  Vector3d slip_B = Vector3d::Zero();  // [m] displacement of A against B since it stuck, axes of B
  bool sliding = false;                // in the last step: a guess for the next
};

// Points are the same when they have moved no farther than this in A between two steps.
constexpr double kSamePoint = 5e-3;  // [m]

}  // namespace hrp
