// SPDX-License-Identifier: BSD-3-Clause
// What the recordings hint at before anything is fitted: StandHints of effects.h.
#pragma once

#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

// The strongest ripples of each drive's residual on training recordings, beside bias, slope, speed, direction and
// acceleration. Only such that repeat within the range of the motion: less than one period looks like a spring.
std::vector<std::vector<double>> find_ripples(const StandProblem& problem, const Evaluation& evaluation);

}  // namespace hrp::diagnosis::standing
