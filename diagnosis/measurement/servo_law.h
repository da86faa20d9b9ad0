// SPDX-License-Identifier: BSD-3-Clause
// Measurement of the servo: recorded effort against kp (command - position) + kd (rates), clamped. No dynamics is in it,
// so it tells late commands from everything that acts on the joint.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

struct ServoDelay {
  int joint = 0;
  double delay = 0.0, std = 0.0;      // [s]
  double before = 0.0, after = 0.0;   // [N m] root mean squares of what the law misses, held-out recordings
};

// Joints whose recorded effort follows the servo's law with commands from `delay` ago, and not with those of the
// moment. Needs recorded commands, positions, velocities and efforts.
std::vector<ServoDelay> find_servo_delays(const Experiment& experiment);

}  // namespace hrp::diagnosis
