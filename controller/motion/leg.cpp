// SPDX-License-Identifier: BSD-3-Clause
#include "controller/motion/leg.h"

#include <cmath>

namespace hrp {
namespace {

// Angle a with y cos(a) - z sin(a) = -offset, for a point (y, z) far above the x axis.
double solve_roll(double y, double z, double offset) { return std::atan2(y, z) + std::asin(offset / std::hypot(y, z)); }

}  // namespace

// Seen from the foot the ankle roll joint is the first: it must bring the hip into the leg's plane, which the ankle
// stands `ankle_offset` beside. Then two links in a plane; the hip takes the attitude that is left.
std::optional<LegAngles> solve_leg(const LegGeometry& leg, const Transform& X_HF) {
  const Vector3d hip_F = -(X_HF.R.transpose() * X_HF.p);
  if (!hip_F.allFinite() || std::hypot(hip_F.y(), hip_F.z()) <= std::abs(leg.ankle_offset)) return std::nullopt;
  const double ankle_roll = solve_roll(hip_F.y(), hip_F.z(), leg.ankle_offset);
  // Hip from the ankle in axes of the ankle pitch link: (x, -offset, z).
  const double x = hip_F.x(), z = std::sin(ankle_roll) * hip_F.y() + std::cos(ankle_roll) * hip_F.z();
  const double length2 = x * x + z * z;
  const double cosine = (length2 - leg.thigh * leg.thigh - leg.shank * leg.shank) / (2.0 * leg.thigh * leg.shank);
  if (!(std::abs(cosine) <= 1.0)) return std::nullopt;
  const double knee = std::acos(cosine);  // positive: shank backwards
  // Shank against the line to the hip, then against the ankle link's z axis.
  const double inner = std::atan2(leg.thigh * std::sin(knee), leg.shank + leg.thigh * cosine);
  const double ankle_pitch = -std::atan2(x, z) - inner;
  // R_HF = Rz(yaw) Rx(roll) Ry(hip + knee + ankle pitch) Rx(ankle roll).
  const Matrix3d R = X_HF.R * Eigen::AngleAxisd(-ankle_roll, Vector3d::UnitX()).toRotationMatrix() *
                     Eigen::AngleAxisd(-(knee + ankle_pitch), Vector3d::UnitY()).toRotationMatrix();
  LegAngles angles;
  angles << std::atan2(-R(0, 1), R(1, 1)), std::asin(std::fmin(std::fmax(R(2, 1), -1.0), 1.0)),
      std::atan2(-R(2, 0), R(2, 2)), knee, ankle_pitch, ankle_roll;
  return angles;
}

}  // namespace hrp
