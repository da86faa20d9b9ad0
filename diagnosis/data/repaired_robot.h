// SPDX-License-Identifier: BSD-3-Clause
// Robots of published URDFs, whose inertias are often placeholders.
#pragma once

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp::diagnosis {

// load_robot(). A simulation refuses inertias that no body can have; the rest of such a model is still worth judging.
// Unless the scenario states 'repair_inertias', they are therefore repaired, with a warning each, and the scenario and
// its text say so from then on: the scenarios that the diagnosis writes run. Throws InputError for all other faults.
RobotDescription load_repaired_robot(Scenario* scenario);

}  // namespace hrp::diagnosis
