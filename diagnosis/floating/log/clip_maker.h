// SPDX-License-Identifier: BSD-3-Clause
// Smoothed clips of a recording, on an even grid and without gaps. The sensors are those of the log (legged_log.h).
#pragma once

#include <string>

#include "diagnosis/floating/log/legged_log.h"

namespace hrp::diagnosis::floating {

// [s] Without a sample: a gap. A body that falls moves 12 mm meanwhile.
constexpr double kLongestStep = 0.05;

// Column of a force sensor; axis: 0 to 2 force x y z [N], 3 to 5 torque x y z [N m].
std::string get_force_column(const std::string& sensor, int axis);

// Adds the clips of recording `index` with the sensors, feet and joints that `log` lists; notes gaps, readings that
// were held, and recordings that are too short.
void add_clips(const Experiment& experiment, size_t index, Half half, LeggedLog* log);

// Fills the roughness of all clips from what the kernel took away.
void scale_roughness(LeggedLog* log);

}  // namespace hrp::diagnosis::floating
