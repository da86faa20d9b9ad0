// SPDX-License-Identifier: BSD-3-Clause
// The attitude of an IMU that does not report it.
#pragma once

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// Fills `attitude` of the recording: from the base's recorded pose and the joints between; else the gyroscope
// integrated, with its slow drift taken out by the specific force less what the robot's own motion over its standing
// foot adds to it. Returns how far off it may be [rad], as a standard deviation.
double find_attitude(const StandProblem& problem, StandRecording* recording);

}  // namespace hrp::diagnosis::standing
