// SPDX-License-Identifier: BSD-3-Clause
// Inverse kinematics of a leg with the joint order hip yaw, roll, pitch, knee, ankle pitch, roll; hip axes meet in one
// point, ankle axes too; the ankle may stand beside the plane of the hip pitch axis.
#pragma once

#include <optional>

#include <Eigen/Dense>

#include "common/spatial/transform.h"

namespace hrp {

struct LegGeometry {
  double thigh = 0.0;         // [m]
  double shank = 0.0;         // [m]
  double ankle_offset = 0.0;  // [m] along y from the leg's plane to the ankle; left positive
};

// Hip yaw, hip roll, hip pitch, knee, ankle pitch, ankle roll [rad] that put the foot (axes of the ankle roll link,
// origin in the ankle) at X_HF, from the hip in base axes. Nothing when out of reach.
using LegAngles = Eigen::Matrix<double, 6, 1>;
std::optional<LegAngles> solve_leg(const LegGeometry& leg, const Transform& X_HF);

}  // namespace hrp
