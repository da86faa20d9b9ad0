// SPDX-License-Identifier: BSD-3-Clause
#include "controller/motion/leg.h"

#include <cmath>

namespace hrp {

std::optional<LegAngles> solve_leg(const LegGeometry& leg, const Eigen::Vector3d& p_HA) {
  // Hip roll phi: in axes turned by it, the ankle is at y = ankle_offset: y cos(phi) + z sin(phi) = offset.
  const double radius = std::hypot(p_HA.y(), p_HA.z());
  if (radius <= std::abs(leg.ankle_offset)) return std::nullopt;
  const double phi = std::atan2(p_HA.z(), p_HA.y()) + std::acos(leg.ankle_offset / radius);
  const double z = -std::sqrt(radius * radius - leg.ankle_offset * leg.ankle_offset);  // downwards in those axes
  // Planar leg of two links in x-z: law of cosines for the knee, positive = shank backwards.
  const double length2 = p_HA.x() * p_HA.x() + z * z;
  const double cosine = (length2 - leg.thigh * leg.thigh - leg.shank * leg.shank) / (2.0 * leg.thigh * leg.shank);
  if (!(std::abs(cosine) <= 1.0)) return std::nullopt;
  const double knee = std::acos(cosine);
  const double hip = std::atan2(-p_HA.x(), -z) - std::atan2(leg.shank * std::sin(knee), leg.thigh + leg.shank * cosine);
  LegAngles angles;
  angles << phi, hip, knee, -(hip + knee), -phi;
  return angles;
}

}  // namespace hrp
