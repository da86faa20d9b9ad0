// SPDX-License-Identifier: BSD-3-Clause
// Repairs typical errors of machine logs if the correction is unambiguous.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Removes jumps of an angle by a whole turn between two samples. Returns their number.
int unwrap_angle(std::vector<double>* angle);

// Replaces single outliers that return at once by NaN. An outlier exceeds ten times the 95 % quantile of second
// differences and eight of the smallest steps; its neighbours agree to a tenth of the jump; the jump is at least
// `of_spread` of the range of the signal's middle 90 %. If more than one sample in a hundred qualifies, the signal is
// left unchanged. Returns the number of replaced samples.
int drop_spikes(std::vector<double>* signal, double of_spread);

// Applies both to all joints of the recording and adds a warning for each changed column. Shifts commands by whole
// turns if they count other turns than their joint.
void repair_recording(const Experiment& experiment, Recording* recording, std::vector<std::string>* warnings);

}  // namespace hrp::diagnosis
