// SPDX-License-Identifier: BSD-3-Clause
// A prediction that another step changes is the integrator's: what recordings differ from it by is no physics.
#pragma once

#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/search/step_check.h"

namespace hrp::diagnosis {

// A warning for each suspect joint.
void warn_of_suspects(const Experiment& e, const std::vector<SuspectJoint>& suspects, nlohmann::ordered_json* report);

// The same; and findings of the simulation there are ambiguous, and what it could not explain there follows nothing.
void doubt_suspects(const Experiment& e, const std::vector<SuspectJoint>& suspects, nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
