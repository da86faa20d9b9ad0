// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/spatial/transform.h"

namespace hrp {

// The turn by a heading [rad] about the vertical.
inline Matrix3d turn_z(double yaw) { return Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix(); }

}  // namespace hrp
