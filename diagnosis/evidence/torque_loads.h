// SPDX-License-Identifier: BSD-3-Clause
// Where a load hangs. Its mass m and its moment m p are linear in the missing torque; its inertia m |p|^2 is not: the
// columns take it at a place that was fitted before.
#pragma once

#include "diagnosis/evidence/torque_model.h"

namespace hrp::diagnosis {

// The design with loads at the places that fit, for every link whose mass is in question in `model`. False, and nothing
// changed, if no place moves by more than a hand's width tells.
bool place_loads(const TorqueModel& model, TorqueDesign* design);

// The same for every link, each with a load of its own beside what every drive has, before anything is chosen: loads far
// from their link's centre of mass lose against wrong gains otherwise. Again, as often as it is true.
bool place_each_load(TorqueDesign* design);

}  // namespace hrp::diagnosis
