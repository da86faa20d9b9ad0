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

// Recorded effort = scale x what the law asks for + bias. Neutral where no law is followed, or no fault is certain.
struct ServoReading {
  bool follows = false;                 // the effort is the servo's, but for these two
  double scale = 1.0, scale_std = 0.0;
  double bias = 0.0, bias_std = 0.0;    // [N m]
  double before = 0.0, after = 0.0;     // [N m] root mean squares of what the law misses, training
  double wavers = 0.0;                  // [N m] the part of `after` that lasts: a log's ripple over position
  double travel = 0.0;                  // [rad] largest less smallest position
  bool is_scaled() const { return scale != 1.0; }
  bool is_biased() const { return bias != 0.0; }
};

// Joints whose recorded effort follows the servo's law with commands from `delay` ago, and not with those of the
// moment. Needs recorded commands, positions and efforts.
std::vector<ServoDelay> find_servo_delays(const Experiment& experiment);

// By joint. Needs what delays need.
std::vector<ServoReading> find_servo_readings(const Experiment& experiment, const std::vector<ServoDelay>& delays);

}  // namespace hrp::diagnosis
