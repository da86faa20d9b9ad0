// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/identification/standing.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/identification/bush_angles.h"

namespace hrp::identification {
namespace {

bool stands(const FootFrame& foot, const Vector6d& wrench) {
  const Vector3d force = wrench.head<3>(), moment = wrench.tail<3>() - foot.p_UC.cross(force);
  if (force.z() < kAirborne) return false;
  if (foot.sole.isEmpty()) return true;
  const Eigen::Vector2d p(-moment.y() / force.z(), moment.x() / force.z());
  return foot.sole.exteriorDistance(p) == 0.0 &&
         std::min((p - foot.sole.min()).minCoeff(), (foot.sole.max() - p).minCoeff()) > kEdge;
}

}  // namespace

std::vector<std::pair<Eigen::Index, Eigen::Index>> find_stretches(const Mask& mask) {
  std::vector<std::pair<Eigen::Index, Eigen::Index>> stretches;
  for (Eigen::Index k = 0; k < mask.size(); ++k) {
    if (!mask[k]) continue;
    if (k == 0 || !mask[k - 1]) stretches.push_back({k, k});
    stretches.back().second = k + 1;
  }
  return stretches;
}

std::vector<Mask> find_standing(const RobotLog& log, const std::vector<FootFrame>& feet,
                                const std::vector<SensorZero>& zeros) {
  std::vector<Mask> standing;
  const Eigen::Index n = log.size(),
                     reach = std::min<Eigen::Index>(n / 2, static_cast<Eigen::Index>(std::ceil(kReach / log.period)));
  for (size_t f = 0; f < feet.size(); ++f) {
    Mask now(n), mask = Mask::Constant(n, true);
    for (Eigen::Index k = 0; k < n; ++k) now[k] = stands(feet[f], log.wrenches[f].col(k) - zeros[f].bias);
    if (n > 2 * reach) {
      now.head(reach).setConstant(now[reach]);
      now.tail(reach).setConstant(now[n - 1 - reach]);
    }
    for (const auto& [first, end] : find_stretches(!now)) {
      const Eigen::Index low = std::max<Eigen::Index>(0, first - reach), high = std::min(n, end + reach);
      mask.segment(low, high - low).setConstant(false);
    }
    standing.push_back(mask);
  }
  return standing;
}

}  // namespace hrp::identification
