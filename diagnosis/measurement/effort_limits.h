// SPDX-License-Identifier: BSD-3-Clause
// Finds the limit of a drive that gives less torque than its log says. Many drives log what they were asked for.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// The limit [N m or N] beyond which the effort of a joint is not there: one, or none. What is beyond it must be the
// whole of what is missing there, and take nine tenths of the squares that friction, a rotor and friction of the load
// leave: a wrong centre of mass took half.
std::vector<double> find_limits(const TorqueData& data, int joint);

}  // namespace hrp::diagnosis
