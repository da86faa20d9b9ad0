// SPDX-License-Identifier: BSD-3-Clause
// Finds the position of loads. The missing torque is linear in a load's mass m and moment m p, but not in its inertia m
// |p|^2. The columns therefore use a position from an earlier fit.
#pragma once

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// Returns the best model, and moves the loads of `design` to fitted positions. First, each load is fitted alone beside
// the usual terms of all drives: loads far from their link's centre of mass would otherwise lose against wrong gains.
// Then loads are fitted in the chosen model, for links whose mass it changes. At last the loads of gears are chosen
// again.
Choice choose_with_placed_loads(int jobs, TorqueDesign* design);

}  // namespace hrp::diagnosis
