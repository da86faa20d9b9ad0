// SPDX-License-Identifier: BSD-3-Clause
// Robots that are mounted otherwise than the model: on a wall, below a ceiling. The weight of all links then acts in
// another direction. Taken joint by joint, it looks like efforts of the wrong sign, and for the whole robot like a
// force.
#pragma once

#include <vector>

#include "diagnosis/conventions/list_fit.h"
#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// [rad] From the stated gravity, beyond what a linear term of a tilt tells: the robot is mounted otherwise.
constexpr double kMounted = 0.5;

// Throws InputError, with the gravity that fits, if that explains the efforts clearly better than every effect under
// the stated one.
void check_mounting(const Experiment& experiment, int jobs);

// Throws InputError, with the gravity that fits, if that explains the efforts clearly better than each of `others`.
void check_gravity_beside(const Experiment& experiment, const std::vector<ListFit>& others, int jobs);

}  // namespace hrp::diagnosis
