// SPDX-License-Identifier: BSD-3-Clause
// Finds how much the time stamps of single rows err, and corrects them.
//
// A log that stamps its rows late by a varying time shows every moving signal a little off, and all of them by the same
// time. Commands tell this time exactly, because they have no noise: from one row to the next, the position of each
// joint's command changes by its commanded rate times the true time between the rows. A row has one stamp, so all
// joints must tell the same time. This holds only if the commands were logged when the measurements were. Therefore the
// measured positions must confirm it: they have to move by what the corrected time says.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// [s] By how much the stamp of each row is late. Empty if the commands do not tell it, if it is negligible beside the
// time between rows, or if the measured positions contradict it.
std::vector<double> find_stamp_errors(const Recording& recording);

// The experiment with corrected stamps, and a warning for each recording that was corrected.
Experiment correct_stamps(Experiment experiment);

}  // namespace hrp::diagnosis
