// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Adds what positions and velocities of a joint say of each other (measurement/velocity_log.h) to the report of a
// search that left its recordings unexplained. Two columns of one joint need no model of the robot, so what they say
// holds whatever a search finds elsewhere. `findings`: those from the missing torque. What the report names at the same
// column stays alone.
void add_column_findings(const std::vector<Finding>& findings, nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
