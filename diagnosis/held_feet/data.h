// SPDX-License-Identifier: BSD-3-Clause
// Reads what rows.h works on.
#pragma once

#include "diagnosis/held_feet/rows.h"

namespace hrp::diagnosis::held_feet {

// Smooths and thins one recording; closes the chain for joints that were not recorded. False when something that the
// equations need is missing; `why` says what.
bool read_row_recording(const RowProblem& problem, const Recording& recording, RowRecording* out, std::string* why);

// Noise of each equation, from what the nominal rows do from one sample to the next.
void find_row_noise(RowProblem* problem);

}  // namespace hrp::diagnosis::held_feet
