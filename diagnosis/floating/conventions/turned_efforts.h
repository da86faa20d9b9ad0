// SPDX-License-Identifier: BSD-3-Clause
// Efforts of legs that a log counts the other way than the model's axes. While legs stand, their torques carry the body
// (equations/leg_forces.h): with one of the wrong sign, they do not balance what the body weighs and how it moves.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

struct TurnedEfforts {
  std::vector<int> joints;
  double left = 1.0;  // share in squares of what does not balance
};

// One joint at a time, as long as each leaves a quarter, and less than any other joint does. Only where no foot feels a force.
TurnedEfforts find_turned_efforts(const Experiment& experiment);

// The experiment with these efforts in the model's sense.
Experiment convert_turned_efforts(Experiment experiment, const TurnedEfforts& turned);

// A sentence.
std::string describe(const Experiment& experiment, const TurnedEfforts& turned);

}  // namespace hrp::diagnosis::floating
