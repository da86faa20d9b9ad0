// SPDX-License-Identifier: BSD-3-Clause
// Where a load hangs. Its mass m and its moment m p are linear in the missing torque; its inertia m |p|^2 is not: the
// columns take it at a place that was fitted before.
#pragma once

#include "diagnosis/evidence/torque_model.h"

namespace hrp::diagnosis {

// The best model, and the design with loads where they fit: first of every link, each alone beside what every drive has, as
// loads far from their link's centre of mass lose against wrong gains otherwise; then of links whose mass is in question in
// the model.
Choice choose_with_placed_loads(int jobs, TorqueDesign* design);

}  // namespace hrp::diagnosis
