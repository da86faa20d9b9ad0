// SPDX-License-Identifier: BSD-3-Clause
// A stated damping gain of the servo that is wrong, where the servo's law gives the effort. No effect of the table
// describes it:
//
//   missing = friction + rotor - (k - 1) kd (r' - v)     the servo has k kd
//
// With k < 1 this is friction that drives the joint, for which lags, delays and constant torques would stand in.
#pragma once

#include <string>

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// What gain the recordings ask for, in a sentence, if with it less than half is left of what the joint's terms in
// `model` leave (squares, on samples that were not fitted); "" if not. Without commanded rates r', it is viscous
// friction, and nothing tells the two apart. `i`: joint of the design.
std::string find_other_damping(const TorqueDesign& design, const TorqueModel& model, size_t i);

}  // namespace hrp::diagnosis
