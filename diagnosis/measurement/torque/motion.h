// SPDX-License-Identifier: BSD-3-Clause
// Smoothed motion, effort and nominal torque of all recordings, with one filter that the noise allows.
#pragma once

#include "diagnosis/measurement/torque/work.h"

namespace hrp::diagnosis {

// Position noise [rad], including the encoder's resolution. A signal that moves less than one step per sample repeats
// its values, so high-pass estimates of its noise give zero.
double find_position_noise(const Experiment& experiment, size_t joint);

// Fills the recordings of `work->data` and its cutoff: the highest one at which noise does not hide what is missing.
void make_torque_motions(TorqueWork* work);

// Fills `slow` of the data, then the sharper `speed` of each recording: from the recorded velocity, else from the
// position. Keeps the smoothed one if both are too noisy.
void make_sharp_speeds(TorqueWork* work);

}  // namespace hrp::diagnosis
