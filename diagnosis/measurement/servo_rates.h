// SPDX-License-Identifier: BSD-3-Clause
// The servo's law where the logs of the velocities were corrected.
#pragma once

#include <vector>

#include "diagnosis/measurement/servo_law.h"
#include "diagnosis/measurement/velocity_log.h"

namespace hrp::diagnosis {

// As find_servo_readings, but `velocity` was corrected in `experiment`. A servo may use the velocity that it logs or a
// sharper one, so a late log of the velocity widens the scale of the effort.
std::vector<ServoReading> find_servo_readings(const Experiment& experiment, const std::vector<ServoDelay>& delays,
                                              const std::vector<VelocityReading>& velocity);

}  // namespace hrp::diagnosis
