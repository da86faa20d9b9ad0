// SPDX-License-Identifier: BSD-3-Clause
// Friction of joints that move at one speed in each direction.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Speeds [rad/s or m/s, signed] at which a joint covers the parts of its way in all recordings. An eighth of the range
// of its positions is a part. Of each part, the first half is left out, in which the joint may still stand.
std::vector<double> list_speeds(const Experiment& experiment, size_t joint);

// True if a joint covers its whole way at about one speed in each direction: a winch, a valve, a motor at one duty.
bool is_of_even_speed(const std::vector<double>& speeds);

// One speed is one point of a friction law. Dry friction, viscous friction and friction with memory that have this
// torque there explain such a motion alike, whatever precedes it: which of them fits a start best is chance. Those
// findings become `ambiguous` and list the others, with the values that take the same torque.
void doubt_friction_of_even_speeds(const Experiment& experiment, nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
