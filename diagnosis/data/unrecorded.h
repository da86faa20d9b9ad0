// SPDX-License-Identifier: BSD-3-Clause
// Joints of which nobody kept a log.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// A gripper whose log nobody kept moves little that the arm feels: fixed at its zero. True: the robot has changed, and its
// recordings must be read again. False: there is none, or the robot's base moves, whose joints may be missing.
bool fix_unrecorded(Experiment* experiment);

}  // namespace hrp::diagnosis
