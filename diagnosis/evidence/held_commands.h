// SPDX-License-Identifier: BSD-3-Clause
// Commands that a servo holds between two samples of a log. Its torque then falls while the joint follows, from one
// command to the next: by kp T v in a period T at a speed v. The log reads it at one instant of each period, and nobody
// knows which one. So its mean is off by up to half of that, which looks like viscous friction of kp T / 2, of either
// sign. In the same way damping looks like a rotor of kd T / 2.
#pragma once

#include <vector>

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// True if nothing says how the joint's command moves between two samples: its rate was not recorded.
bool may_hold_commands(const Experiment& experiment, int joint);

// [kg m^2] Inertia at which the velocity ripples between held commands by this factor of the mean rate, at the instant
// just before or after a command: T^2 kp / (12 |1 - scale|). 0 if commands are not held, or if the joint's own link has
// more.
double calc_rippling_inertia(const Experiment& experiment, int joint, double scale);

// Widens the intervals of viscous friction and of rotors by these bounds, where commands may be held. Findings whose
// interval then contains none are ambiguous.
void widen_by_held_commands(const TorqueDesign& design, std::vector<GradedTerm>* graded);

}  // namespace hrp::diagnosis
