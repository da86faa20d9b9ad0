// SPDX-License-Identifier: BSD-3-Clause
// Estimates the attitude of an IMU that does not report one.
#pragma once

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// Fills `attitude` of the recording. It comes from the recorded pose of the base and the joints between, if there is
// one. Otherwise the gyroscope is integrated, and its slow drift is corrected by the direction of gravity. This
// direction is the specific force minus the robot's own acceleration relative to its standing feet. Returns the
// standard deviation of the attitude [rad]; 0 with a recorded base pose.
double find_attitude(const StandProblem& problem, StandRecording* recording);

}  // namespace hrp::diagnosis::standing
