// SPDX-License-Identifier: BSD-3-Clause
// Says of efforts that are no torques in which unit they are logged (measurement/effort_units.h).
#pragma once

#include "diagnosis/measurement/effort_units.h"
#include "diagnosis/report/first.h"

namespace hrp::diagnosis {

// Empty: efforts are torques, or nothing tells. Throws InputError for turned signs.
std::vector<EffortUnit> find_effort_units(const Experiment& experiment);

// Adds a finding for each joint, its entry in the model, and a warning. The rest of the report is about efforts in N m: a
// gain that was found beside multiplies.
void add_effort_units(const Experiment& as_logged, const std::vector<EffortUnit>& units, Reports* reports);

}  // namespace hrp::diagnosis
