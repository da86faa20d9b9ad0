// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "diagnosis/identification/bush_angles.h"
#include "diagnosis/identification/smoothing.h"

namespace hrp::identification {

bool has_slipped(const MotionTrack& track) { return track.slip > kSlipDistance || track.turn > kSlipTurn; }

Mask MotionTrack::find_usable(size_t foot, double skip) const {
  Mask usable = stands[foot];
  const auto rest = static_cast<Eigen::Index>(std::ceil(skip / period));
  for (const auto& [first, end] : find_stretches(stands[foot]))
    usable.segment(first, std::min(rest, end - first)).setConstant(false);
  return usable;
}

Eigen::VectorXd MotionTrack::thin(const Eigen::VectorXd& signal, int order) const {
  const auto first = static_cast<Eigen::Index>(std::lround(time[0] / log_period));
  return GaussianFilter(kSmoothing, log_period).sample(signal, order, first, kThinning, time.size());
}

}  // namespace hrp::identification
