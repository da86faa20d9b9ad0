// SPDX-License-Identifier: BSD-3-Clause
// A joint's recorded velocity against the rate of its recorded position. No dynamics is in it, so it tells faults of the
// two columns from everything that acts on the joint.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Recorded velocity at t = scale x rate of the recorded position at t - late + bias. Neutral where velocities do not follow the
// position, or no fault is certain.
struct VelocityReading {
  double scale = 1.0, scale_std = 0.0;
  double late = 0.0, late_std = 0.0;  // [s] negative: the position is the late one, as no filter looks ahead
  double bias = 0.0, bias_std = 0.0;  // [rad/s]
  double ratio = 0.0, ratio_std = 0.0;  // of velocity over rate, also where it is no certain fault; 0: none
  double before = 0.0, after = 0.0;   // [rad/s] root mean squares of what the rate misses, without these and with them
  bool is_scaled() const { return scale != 1.0; }
  bool is_late() const { return late > 0.0; }
  bool is_position_late() const { return late < 0.0; }
  bool is_biased() const { return bias != 0.0; }
  bool is_faulty() const { return is_scaled() || is_biased() || late != 0.0; }
};

// By joint, from the recordings of training.
std::vector<VelocityReading> find_velocity_readings(const Experiment& experiment);

// Whether stamps that are as far off would do the same: all joints whose velocities follow have that scale.
bool may_be_clock(const std::vector<VelocityReading>& readings, const VelocityReading& scaled);

// Velocities less their bias and over their scale, positions and velocities moved by their delays: linear between samples,
// held at the ends.
Experiment correct_joint_logs(const Experiment& experiment, const std::vector<VelocityReading>& readings);

}  // namespace hrp::diagnosis
