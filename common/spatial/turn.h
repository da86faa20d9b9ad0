// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/spatial/transform.h"

namespace hrp {

// The turn by a rotation vector [rad], about its direction by its length.
inline Eigen::AngleAxisd make_turn(const Vector3d& rotation) {
  const double angle = rotation.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, rotation / angle) : Eigen::AngleAxisd(0.0, Vector3d::UnitX());
}

}  // namespace hrp
