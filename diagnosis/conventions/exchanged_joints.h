// SPDX-License-Identifier: BSD-3-Clause
// Columns of two joints that are exchanged in a log: drivers sort joints by name, scripts by number.
#pragma once

#include "diagnosis/conventions/logged_motion.h"
#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// Throws InputError, with file and column, if the recordings fit the model with two joints exchanged, clearly better
// than with every effect of the list as logged. Efforts must be torques in the model's unit.
void check_exchanged_joints(const TorqueData& data, const LoggedMotion& motion, int jobs);

}  // namespace hrp::diagnosis
