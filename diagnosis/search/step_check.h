// SPDX-License-Identifier: BSD-3-Clause
// Finds predictions that depend on the integrator's step rather than on the robot.
#pragma once

#include <vector>

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// A joint whose nominal prediction changes with half the step by a good part of its residual.
struct SuspectJoint {
  int joint = 0;
  double change = 0.0;     // rms change of the reading that changes most, in units of noise
  double left = 0.0;       // rms residual of that reading, in units of noise
  bool saturated = false;  // the predicted servo is at its limit for over a tenth of the time
};

// Compares nominal rollouts with full and with half steps on the training recordings.
std::vector<SuspectJoint> find_suspect_joints(const Problem& problem);

}  // namespace hrp::diagnosis
