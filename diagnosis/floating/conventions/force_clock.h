// SPDX-License-Identifier: BSD-3-Clause
// The clock of the feet's force sensors against that of the body's motion: the sum of the forces follows mass times
// acceleration, whatever shakes beside it.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/floating/log/body_motion.h"

namespace hrp::diagnosis::floating {

// What feet feel and what the motion takes, at even stamps of one stretch.
struct PressedStretch {
  int recording = 0;
  double step = 0;                         // [s]
  std::vector<std::vector<double>> force;  // [N], or in a unit of the sensors; by foot
  std::vector<double> needed;              // [N]; not finite: unknown
};

constexpr double kNearForce = 0.12;  // [s] by which forces are looked for on either side

struct ForceClock {
  std::optional<size_t> foot;  // whose force is late: one foot's; none: that of all
  double late = 0, std = 0;    // [s] of the force behind the motion
  double agreement = 0,
         as_logged = 0;  // share of the forces' squares that follows the motion, with the shift and without
  double nats = 0;       // of the shift's likelihood, but for a constant: blocks are independent
  bool found = false;
  std::vector<ForceClock> rivals;  // other feet, or all, that do as well
};

// The best of all feet together and of each foot alone, where there are several. `sample_time` [s] of the recordings:
// nobody knows more exactly when the sensors of one row were read.
ForceClock find_force_clock(const std::vector<PressedStretch>& stretches, double sample_time);

// Empty where a foot's vertical force is unknown, or has other axes beside it, or the motion is told by another source;
// kNone: any does.
std::vector<PressedStretch> list_pressed(const LeggedLog& log, MotionSource source = MotionSource::kImu);

// Encoders of standing legs are asked whose clock it is.
Finding make_clock_finding(const LeggedLog& log, const ForceClock& clock);

}  // namespace hrp::diagnosis::floating
