// SPDX-License-Identifier: BSD-3-Clause
// Handles predictions that change with the integrator's step. Differences from the recordings are then no physics.
#pragma once

#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/search/step_check.h"

namespace hrp::diagnosis {

// Adds a warning for each suspect joint.
void warn_of_suspects(const Experiment& e, const std::vector<SuspectJoint>& suspects, nlohmann::ordered_json* report);

// The same; and makes findings of the simulation at these joints ambiguous, without dependence of what remains there.
void doubt_suspects(const Experiment& e, const std::vector<SuspectJoint>& suspects, nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
