// SPDX-License-Identifier: BSD-3-Clause
// How large the torques of weight and inertia are one by one. In free motion they cancel, and their sum says nothing of
// it.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// Mean square of gravity's torque plus that of the motion's, by joint, along all recordings [(N m)^2 or N^2].
std::vector<double> calc_passive_squares(const TorqueData& data);

}  // namespace hrp::diagnosis
