// SPDX-License-Identifier: BSD-3-Clause
// Where the effort of a drive comes from: its log, or the servo's law.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

EffortSource find_effort_source(const Experiment& experiment, size_t joint);

// What is not said of a joint's drive because its effort was not logged, with the files; empty if everything is.
std::string describe_unlogged(const Experiment& experiment, int joint, EffortSource source);

// Name of a column of Recording::other: the velocity [rad/s] with which a joint's servo damps, where that is not the
// corrected one.
std::string name_servo_rate(size_t joint);

// Effort by the servo law at the recording's own samples [N m], and its rate from the commands [N m/s].
struct ServoSeries {
  std::vector<double> effort, command_rate;
};

// `rate` [rad/s]: the velocity that the servo uses, at the recording's samples.
ServoSeries calc_servo(const Recording& recording, size_t joint, const JointLaws& laws,
                       const std::vector<double>& rate);

}  // namespace hrp::diagnosis
