// SPDX-License-Identifier: BSD-3-Clause
// Converts a hypothesis to the world and the pose sensor of a simulation.
#pragma once

#include "diagnosis/toss/fit.h"

namespace hrp::diagnosis::toss {

// Maps true poses to recorded ones.
struct PoseSensor {
  double scale = 1.0;                 // of positions
  Vector3d bias{0, 0, 0};             // [m]
  Matrix3d R = Matrix3d::Identity();  // of the tracked frame in the body
  double delay = 0.0;                 // [s] of attitudes
  double skew = 0.0;                  // a stamp t belongs to the true time t (1 + skew)
};

struct TossModel {
  World world;
  PoseSensor sensor;
};

// The nominal world and an ideal sensor, changed by the effects of the hypothesis.
TossModel make_toss_model(const TossProblem& problem, const Hypothesis& hypothesis);

}  // namespace hrp::diagnosis::toss
