// SPDX-License-Identifier: BSD-3-Clause
// Repairs typical errors of machine logs if the correction is unambiguous.
#pragma once

#include <array>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

constexpr double kJump = 1.5 * M_PI;  // [rad] no joint moves so far between two samples: its angle was wrapped

// Removes jumps of an angle by a whole turn between two samples. Returns their number.
int unwrap_angle(std::vector<double>* angle);

// Replaces single outliers that return at once by NaN. An outlier exceeds ten times the 95 % quantile of second
// differences and eight of the smallest steps; its neighbours agree to a tenth of the jump; the jump is at least
// `of_spread` of the range of the signal's middle 90 %. If more than one sample in a hundred qualifies, the signal is
// left unchanged. Returns the number of replaced samples.
int drop_spikes(std::vector<double>* signal, double of_spread);

// Makes the signs of an attitude's quaternions continuous: q and -q are one attitude, and loggers write either. A
// sample whose norm is not 1, such as the zeros of an IMU that estimates no attitude, becomes NaN. `xyzw` has the four
// columns. Returns the first such norm; NaN if there is none.
double repair_attitude(const std::array<std::vector<double>*, 4>& xyzw);

// Takes out the four columns of "/imu/trunk/orientation".
void drop_attitude(const std::string& name, Recording* recording);

// Applies all to the recording and adds a warning for each changed column. Shifts commands by whole turns if they count
// other turns than their joint. Leaves out attitudes without a sample.
void repair_recording(const Experiment& experiment, Recording* recording, std::vector<std::string>* warnings);

}  // namespace hrp::diagnosis
