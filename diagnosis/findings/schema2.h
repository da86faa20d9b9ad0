// SPDX-License-Identifier: BSD-3-Clause
// Reports of engines that speak schema 1, as schema 2.
#pragma once

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Adds what schema 2 has beside schema 1: findings are certain (supported where nothing was held out, ambiguous where an
// interval holds the effect's absence), take away what the fit says, and have a family; the verdict of recordings that
// could not be judged is `not_judged`.
void upgrade_report(nlohmann::ordered_json* report, bool has_held);

// Grade, and the grade that its statement names.
void make_ambiguous(nlohmann::ordered_json* finding);

// " These recordings cannot tell it from mass_error at arm, com_error at arm."; "" without any.
std::string describe_alternatives(const nlohmann::ordered_json& alternatives);

// Findings of a simulation that nothing was held out from: those that the missing torque does not support as well, at the
// same place, are ambiguous, with what it cannot tell them from.
void doubt_unconfirmed(const std::vector<Finding>& torque, nlohmann::ordered_json* report);

// Whatever engine found it: what an interval says may not be there is ambiguous, and so is everything where the held-out
// recordings are predicted no better.
void lower_grades(nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
