// SPDX-License-Identifier: BSD-3-Clause
// Hints from the recordings before any fit: StandHints of effects.h.
#pragma once

#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

// Wave numbers [1/rad], by joint, of the strongest ripples of the drive's residual in training recordings, beside bias,
// slope, speed, direction and acceleration. Only ripples with at least one period within the motion: shorter motion
// makes a ripple look like a spring.
std::vector<std::vector<double>> find_ripples(const StandProblem& problem, const Evaluation& evaluation);

}  // namespace hrp::diagnosis::standing
