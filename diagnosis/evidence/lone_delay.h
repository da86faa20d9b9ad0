// SPDX-License-Identifier: BSD-3-Clause
// Late commands of a single joint. A servo with gains kp and kd that answers T0 late gives the torque of a servo that
// does not, less about kp T0 times the speed: what viscous friction takes, with a rotor for the next order.
#pragma once

#include <vector>

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// A joint's delay is ambiguous unless it leaves less than half (root mean square, held out) of what the friction and
// the rotor that every drive has leave in its place. Adds these to its rivals.
void doubt_lone_delays(const TorqueDesign& design, const Choice& choice, std::vector<GradedTerm>* graded);

// Viscous friction in one proportion to the stated kp at all joints, where no effort was logged, is ambiguous: commands
// that come T0 late take kp T0 at every joint, while friction of drives differs.
void doubt_viscous_of_one_delay(const TorqueDesign& design, std::vector<GradedTerm>* graded);

}  // namespace hrp::diagnosis
