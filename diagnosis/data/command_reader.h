// SPDX-License-Identifier: BSD-3-Clause
// Values of a recording between its samples. `near` is a sample close to time t, where the search begins.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Linear; constant beyond the ends.
double interpolate(const std::vector<double>& time, const std::vector<double>& values, double t, size_t near);

// Where t lies: between samples k and k + 1, at share s of the way (0 to 1, clamped at the ends).
struct Moment {
  size_t k = 0;
  double s = 0.0;
  double of(const std::vector<double>& values) const { return values[k] + s * (values[k + 1] - values[k]); }
};
Moment find_moment(const std::vector<double>& time, double t, size_t near);

// Cubic Hermite interpolation of a joint's command; linear where no rate was recorded or where the rate is no derivative
// of the position (a drive that is always told to stand, on its way through a staircase of positions); held beyond the ends; 0 where
// there is no command. The rate is the cubic's, or linear between recorded ones where the command is rough.
void read_command(const std::vector<double>& time, const JointColumns& joint, double t, size_t near, double* position,
                  double* rate);

}  // namespace hrp::diagnosis
