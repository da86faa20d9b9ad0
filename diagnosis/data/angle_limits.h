// SPDX-License-Identifier: BSD-3-Clause
// Angles far beyond the limits of their joint: degrees, the angle of a motor before its gear, or damaged samples.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Throws InputError, with file and column, for a position three times beyond the joint's limits and beyond a whole
// turn.
void check_limits(const Experiment& experiment, const Recording& recording, int joint);

// Warns of commands far beyond the limits: a damaged sample, or a drive that receives torques as positions.
void check_commanded_limits(Experiment* experiment, const Recording& recording, int joint);

}  // namespace hrp::diagnosis
