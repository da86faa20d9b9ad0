// SPDX-License-Identifier: BSD-3-Clause
// Handles joints without recordings.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Fixes joints without recordings at zero, such as those of a gripper, whose motion hardly affects the arm. Returns
// true if the robot changed; its recordings must then be read again. Returns false if there are none, or if the base
// moves, where joints may be missing.
bool fix_unrecorded(Experiment* experiment);

}  // namespace hrp::diagnosis
