// SPDX-License-Identifier: BSD-3-Clause
// Noise of recorded signals: as the experiment states, else estimated from the signals.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Standard deviation of a signal's noise, from the median absolute third difference with the factor for normal noise.
// It is robust against jumps, and insensitive to motion that is a cubic over four samples.
double estimate_noise(const std::vector<double>& signal);

// [rad] Step of a joint's encoder, from the small differences of its samples; 0 if it hardly changes. Of an encoder
// that resolves more than its joint moves between samples: some small motion.
double find_encoder_step(const Experiment& experiment, size_t joint);

// Fills joint_noise and other_noise. All deviations are positive.
void find_noise(Experiment* experiment);

}  // namespace hrp::diagnosis
