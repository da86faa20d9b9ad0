// SPDX-License-Identifier: BSD-3-Clause
// Inverse kinematics of a leg with the joint order hip yaw, roll, pitch, knee, ankle pitch, roll; hip axes meet in one
// point, ankle axes too; the ankle may stand beside the plane of the hip pitch axis.
#pragma once

#include <optional>

#include <Eigen/Dense>

namespace hrp {

struct LegGeometry {
  double thigh = 0.0;         // [m]
  double shank = 0.0;         // [m]
  double ankle_offset = 0.0;  // [m] along y from the leg's plane to the ankle; left positive
};

// Hip roll, hip pitch, knee, ankle pitch, ankle roll [rad] that put the ankle at p_HA, from the hip in base axes, with
// yaw zero and the sole parallel to the base's x-y plane. Nothing when out of reach.
using LegAngles = Eigen::Matrix<double, 5, 1>;
std::optional<LegAngles> solve_leg(const LegGeometry& leg, const Eigen::Vector3d& p_HA);

}  // namespace hrp
