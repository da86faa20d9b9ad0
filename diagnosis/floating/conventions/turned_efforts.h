// SPDX-License-Identifier: BSD-3-Clause
// Efforts of legs that a log counts the other way than the model's axes. While legs stand, their torques carry the body
// (equations/leg_forces.h): with one of the wrong sign, they do not balance what the body weighs and how it moves.
#pragma once

#include <string>

#include "diagnosis/floating/conventions/turned_joints.h"

namespace hrp::diagnosis::floating {

// One joint at a time, as long as each leaves a quarter, and less than any other joint does. Only where no foot feels a
// force.
TurnedJoints find_turned_efforts(const Experiment& experiment);

// The experiment with these efforts in the model's sense.
Experiment convert_turned_efforts(Experiment experiment, const TurnedJoints& turned);

// A sentence.
std::string describe_turned_efforts(const Experiment& experiment, const TurnedJoints& turned);

}  // namespace hrp::diagnosis::floating
