// SPDX-License-Identifier: BSD-3-Clause
// Recordings that contradict themselves: degrees for radians, exchanged joints, turned signs, encoders that stand
// still. Whatever physics is missing, a reading in rad follows its command one to one and a drive logs its servo's law,
// so these are told before anything is fitted, and no cause is named for them.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Throws InputError with file and column of what cannot be as recorded. Columns that say nothing (an effort that is
// always 0, as drives without a torque sensor publish it) are dropped with a warning.
void check_plausibility(Experiment* experiment);

}  // namespace hrp::diagnosis
