// SPDX-License-Identifier: BSD-3-Clause
// A spring or a counterweight that balances a joint takes the torque of weight off its drive, as a force that lifts the
// link does. A force at a link acts at all joints that carry it; a balancer acts at its own.
#pragma once

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// Forces along gravity that one joint alone shows are ambiguous, and say so.
void doubt_balancers(const TorqueDesign& design, std::vector<GradedTerm>* graded);

}  // namespace hrp::diagnosis
