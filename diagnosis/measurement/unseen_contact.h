// SPDX-License-Identifier: BSD-3-Clause
// A robot on a rail or boom that hops or steps on ground whose force nobody recorded. The ground's force acts at every
// joint between the rail and the foot, and springs, zeros and loads would stand in for it.
#pragma once

#include "diagnosis/measurement/torque/work.h"

namespace hrp::diagnosis {

// A joint without a drive, on which gravity always pulls alike, weighs the robot: along it, what pushes from outside is
// the inverse dynamics. If that carries most of the weight on average, never pulls, and lets go at times, it is ground.
// Samples on the ground are left out at all joints, and a warning says so. Only if no foot's force was recorded.
void leave_out_unseen_contact(TorqueWork* work);

}  // namespace hrp::diagnosis
