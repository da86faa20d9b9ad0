// SPDX-License-Identifier: BSD-3-Clause
// Noise of recorded signals: as the experiment states it, else from the signals themselves.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Noise of a signal from its high-frequency content: the median absolute third difference, with the normal
// distribution's factor; robust against jumps and blind to anything as smooth as a cubic over four samples.
double estimate_noise(const std::vector<double>& signal);

// Fills joint_noise and other_noise. No deviation is zero.
void find_noise(Experiment* experiment);

}  // namespace hrp::diagnosis
