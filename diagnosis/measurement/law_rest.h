// SPDX-License-Identifier: BSD-3-Clause
// What the servo's law misses of a joint's effort log. It does not depend on the dynamics, so what it has over the position is a
// fault of the log, and no torque on the joint.
#pragma once

#include "diagnosis/measurement/servo_law.h"

namespace hrp::diagnosis {

// Training samples where the drive is not at its limit.
struct LawRest {
  std::vector<double> position;  // [rad]
  std::vector<double> torque;    // [N m] log - (scale x law + bias)
};

// Empty if the log does not follow the law. `late`: the joint's delays of commands are among them.
LawRest list_law_rest(const Experiment& experiment, int joint, const ServoReading& log, const std::vector<ServoDelay>& late);

}  // namespace hrp::diagnosis
