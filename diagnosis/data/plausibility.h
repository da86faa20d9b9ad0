// SPDX-License-Identifier: BSD-3-Clause
// Detects recordings that contradict themselves: degrees instead of radians, exchanged joints, wrong signs, frozen
// encoders. Whatever physics is missing, a position in rad follows its command one to one, and a drive logs its servo's
// law. Therefore these faults are found before any fit, and no physical cause is named for them.
#pragma once

#include <cmath>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

constexpr double kDegrees = 180.0 / M_PI;  // [degrees/rad]

// Throws InputError with file and column of an impossible recording. Columns without information (such as an effort
// that is always 0, without a torque sensor) are dropped with a warning.
void check_plausibility(Experiment* experiment);

// Joints whose logged effort is minus the servo's law in some recording, and the law itself in none.
std::vector<int> list_turned_by_law(const Experiment& experiment);

// Largest absolute value of the finite ones; 0 without any.
double find_largest(const std::vector<double>& values);

// True if a joint's largest angle is far beyond its limits [rad], but not in degrees.
bool may_be_degrees(const JointSpec& joint, double largest);

}  // namespace hrp::diagnosis
