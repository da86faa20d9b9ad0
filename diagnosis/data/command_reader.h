// SPDX-License-Identifier: BSD-3-Clause
// Values of a recording between its samples. `near`: a sample index close to time t, where the search starts.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Linear interpolation; constant beyond the ends.
double interpolate(const std::vector<double>& time, const std::vector<double>& values, double t, size_t near);

// Shifts a series: its value at each stamp becomes that of `late` [s] later. Missing samples (NaN) stay missing.
void move_series(const std::vector<double>& time, double late, std::vector<double>* series);

// Position of time t: between samples k and k + 1, at fraction s (0 to 1, clamped at the ends).
struct Moment {
  size_t k = 0;
  double s = 0.0;
  double of(const std::vector<double>& values) const { return values[k] + s * (values[k + 1] - values[k]); }
};

// Finds t by a search that starts at sample `near`.
Moment find_moment(const std::vector<double>& time, double t, size_t near);

// Position and rate of a joint's command at time t [s]: cubic Hermite interpolation. Linear if no rate was recorded or
// the rate is no derivative of the position (such as zero rates with a staircase of positions). Constant beyond the
// ends; 0 without a command. The rate is the cubic's, or interpolated linearly if the command is rough.
void read_command(const std::vector<double>& time, const JointColumns& joint, double t, size_t near, double* position,
                  double* rate);

}  // namespace hrp::diagnosis
