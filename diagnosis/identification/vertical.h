// SPDX-License-Identifier: BSD-3-Clause
// What the paper left open: the bush's vertical displacement and its stiffness, from accelerometer and closed chain.
//
// The chain from the sole gives the height of the IMU but for the slide, the accelerometer its acceleration:
//   slide'' = (height of the chain)'' - (acceleration of the IMU)
// and the rubber says slide = s (load - T load' + ...), s = 1 / kz, T = cz / kz. A robot that bounces shows both. With
// both feet down the closed chain gives the difference of the two slides itself.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/identification/bush_fit.h"

namespace hrp::identification {

struct VerticalFit {
  std::vector<Estimate> compliance;  // [m/N] by foot: 1 / kz
  std::vector<Estimate> stiffness;   // [N/m]
  std::vector<Estimate> damping;     // [N s/m] cz
};
// Empty when the motions do not show it (a compliance less than four standard deviations from zero). What noise alone
// does to the rows is known from the hanging robot and taken off the normal equations (errors in variables).
VerticalFit fit_vertical(const std::vector<MotionTrack>& tracks, const std::optional<MotionTrack>& hanging = {});

// Slide of one foot along a motion [m], positive when pressed, from its load.
Eigen::VectorXd calc_slide(const VerticalFit& fit, const MotionTrack& track, size_t foot);

}  // namespace hrp::identification
