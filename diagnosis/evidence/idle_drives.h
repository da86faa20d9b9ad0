// SPDX-License-Identifier: BSD-3-Clause
// Drives that did not move the robot: it was moved by hand, or its log holds no efforts but noise.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// True if no recorded effort follows the joint's own torque, acceleration, speed, direction or position (on stretches
// that were not fitted, a tenth of its square is predicted at none of the judged joints), and the robot does not move
// freely. False without recorded efforts, and on a floating base: feet carry it, too.
bool are_drives_idle(const TorqueData& data);

// Nothing about drives, masses and gravity is supported then: the hand's forces are in no log.
void doubt_idle_drives(const TorqueData& data, Evidence* evidence);

}  // namespace hrp::diagnosis
