// SPDX-License-Identifier: BSD-3-Clause
// Compares the recorded effort with the servo's law kp (command - position) + kd (rates), clamped. This needs no
// dynamics, so it separates late commands from everything that acts on the joint.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

struct ServoDelay {
  int joint = 0;
  double delay = 0.0, std = 0.0;     // [s]
  double before = 0.0, after = 0.0;  // [N m] rms residual of the law, held-out recordings
};

// Recorded effort = scale x law + bias. Neutral if the effort does not follow a law or no fault is significant.
struct ServoReading {
  bool follows = false;  // the effort is that of the servo, except for scale and bias
  double slope = 0.0;    // of the effort over the law's [1], where it is proportional in any unit, else 0
  double scale = 1.0, scale_std = 0.0;
  double bias = 0.0, bias_std = 0.0;  // [N m]
  double before = 0.0, after = 0.0;   // [N m] rms residual of the law, training recordings
  double wavers = 0.0;                // [N m] correlated part of `after`, such as the log's ripple over position
  double travel = 0.0;                // [rad] range of the positions
  bool is_scaled() const { return scale != 1.0; }
  bool is_biased() const { return bias != 0.0; }
};

// Joints whose recorded effort follows the servo's law with commands from `delay` ago, but not with current ones. Needs
// recorded commands, positions and efforts.
std::vector<ServoDelay> find_servo_delays(const Experiment& experiment);

// By joint. Needs the same columns as delays.
std::vector<ServoReading> find_servo_readings(const Experiment& experiment, const std::vector<ServoDelay>& delays);

}  // namespace hrp::diagnosis
