// SPDX-License-Identifier: BSD-3-Clause
// Joints that are stopped within their travel: by a mechanical stop, a table, a cable that tightens. No law on the list
// has a corner over position, so masses and friction would stand for it.
#pragma once

#include "diagnosis/measurement/torque/work.h"

namespace hrp::diagnosis {

// Leaves out the samples of a joint beyond the angle where something stops it, with a warning. There is such an angle
// if friction, a rotor, a spring and other torques that are smooth over position leave a hundredth of the mean square
// on this side of it, and if the torque beyond pushes back. Only of drives that follow efforts: late commands that jump
// look like stops.
void leave_out_stops(TorqueWork* work, int joint);

}  // namespace hrp::diagnosis
