// SPDX-License-Identifier: BSD-3-Clause
// Predictions that are the integrator's and not the robot's: those that another step changes.
#pragma once

#include <vector>

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// A joint whose nominal prediction differs with half the step by much of what the recordings differ from it.
struct SuspectJoint {
  int joint = 0;
  double change = 0.0;     // root mean square, noise deviations, of the reading that changes most
  double left = 0.0;       // of what the recordings differ from the prediction there
  bool saturated = false;  // the predicted servo is at its limit for more than a tenth of the time
};

std::vector<SuspectJoint> find_suspect_joints(const Problem& problem);

// Joints whose servo hums at its effort limit faster than a log samples: at the limit for most of the time, with a velocity
// that is not the rate of the position. Simulated recordings of stiff servos on light links are such. And those that it
// shakes: their velocity is not the position's rate either.
struct Hum {
  std::vector<int> humming, shaken;
};
Hum find_hum(const Experiment& e);

}  // namespace hrp::diagnosis
