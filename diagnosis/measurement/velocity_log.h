// SPDX-License-Identifier: BSD-3-Clause
// Compares a joint's recorded velocity with the rate of its recorded position. This needs no dynamics, so it separates
// faults of the two columns from everything that acts on the joint.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Recorded velocity at t = scale x rate of the recorded position at t - late + bias. Neutral if the velocity does not
// follow the position or no fault is significant.
struct VelocityReading {
  double scale = 1.0, scale_std = 0.0;
  // [s] negative: the position is late, because no filter looks ahead. Above kLongest: time constant of a slow filter.
  double late = 0.0, late_std = 0.0;
  double bias = 0.0, bias_std = 0.0;    // [rad/s]
  double ratio = 0.0, ratio_std = 0.0;  // velocity over rate, even if not significant; 0: unknown
  double before = 0.0, after = 0.0;     // [rad/s] rms residual of the rate, without and with these corrections
  bool is_scaled() const { return scale != 1.0; }
  bool is_late() const { return late > 0.0; }
  bool is_position_late() const { return late < 0.0; }
  bool is_biased() const { return bias != 0.0; }
  bool is_faulty() const { return is_scaled() || is_biased() || late != 0.0; }
};

// By joint, from the training recordings.
std::vector<VelocityReading> find_velocity_readings(const Experiment& experiment);

// True if wrong time stamps could have the same effect: all joints with a known ratio have this scale.
bool may_be_clock(const std::vector<VelocityReading>& readings, const VelocityReading& scaled);

// Corrects velocities for bias and scale, and shifts velocities and positions by their delays: linear between samples,
// constant at the ends. Velocities behind a slow filter are left out: the rate of the position is sharper.
Experiment correct_joint_logs(const Experiment& experiment, const std::vector<VelocityReading>& readings);

}  // namespace hrp::diagnosis
