// SPDX-License-Identifier: BSD-3-Clause
// A joint of a leg whose encoder counts the other way than the model's axis. While two feet stand, neither moves in the
// world: flat feet keep their pose in each other's axes, balls keep their distance; where the base's pose or attitude
// is recorded, each keeps its own in the world. A joint that is turned makes them move. This needs encoders and feet
// that stand, and no IMU.
#pragma once

#include <string>

#include "diagnosis/floating/conventions/turned_joints.h"

namespace hrp::diagnosis::floating {

// One joint at a time, as long as each leaves a quarter, and less than any other joint does. Empty where two explain as
// much.
TurnedJoints find_turned_legs(const Experiment& experiment);

// The experiment with readings and commands of these joints in the model's sense.
Experiment convert_turned_legs(Experiment experiment, const TurnedJoints& turned);

// A sentence.
std::string describe_turned_legs(const Experiment& experiment, const TurnedJoints& turned);

}  // namespace hrp::diagnosis::floating
