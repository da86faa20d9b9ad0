// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "common/spatial/transform.h"

namespace hrp {

// Inverse of make_rotation_from_rpy(): R = Rz(yaw) Ry(pitch) Rx(roll). Exact to rounding, also where pitch is a right
// angle.
inline Vector3d calc_rpy(const Matrix3d& R) {
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  // What yaw leaves of the second column is exact where the third row vanishes.
  const double s = std::sin(yaw), c = std::cos(yaw);
  const double roll = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));
  return {roll, pitch, yaw};
}

}  // namespace hrp
