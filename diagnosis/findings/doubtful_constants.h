// SPDX-License-Identifier: BSD-3-Clause
// Constant torques in joints, where the place of a mass or the zero of a command is in question.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Drives of legs bear what stands on them, and force sensors under the feet tell with which moments. As long as an
// ambiguous finding may be a mass or its place, or is only told apart from one by a sensor's zero, constant torques may
// be its weight. As long as it may be a turned IMU, gravity may act otherwise than the IMU says. They become
// `ambiguous`, with those effects among their alternatives. Does nothing on a fixed base.
void doubt_constants_of_masses(const Experiment& experiment, nlohmann::ordered_json* report);

// Zeros of the force sensor in a foot that never lifts, up to a hundredth of the robot's weight, are constant torques
// of all joints above it. A constant torque of such a joint that takes no larger zero becomes `ambiguous`, with that
// sensor among its alternatives. `certain` ones stay: where all is explained, the other joints would show the zero.
// Does nothing on a fixed base.
void doubt_constants_of_feet(const Experiment& experiment, nlohmann::ordered_json* report);

// A servo whose commands count from another zero than its positions: its effort is off what its law asks for by a
// constant, and corrected for that, the joint seems to need the opposite constant torque. The two findings cancel. Both
// become `ambiguous` and name the zero, which explains them with one number.
void doubt_constants_of_commands(const Experiment& experiment, nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
