// SPDX-License-Identifier: BSD-3-Clause
// Converts reports of schema 1 to schema 2.
#pragma once

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Adds the fields of schema 2: grade, family, share, ceiling and others. Findings are certain; supported without
// held-out recordings or unless all is explained; ambiguous if an interval contains the neutral value or another family
// fits as well. Recordings that could not be judged get the verdict `not_judged`.
void upgrade_report(nlohmann::ordered_json* report, bool has_held);

// Whether a finding's interval has this value in it; false for what is no interval.
bool holds(const nlohmann::ordered_json& interval, double value);

// Sets the grade `ambiguous`, also in the statement.
void make_ambiguous(nlohmann::ordered_json* finding);

// For simulations without held-out recordings: makes findings ambiguous that the missing torque does not support at the
// same place, and adds its alternatives.
void doubt_unconfirmed(const std::vector<Finding>& torque, nlohmann::ordered_json* report);

// Makes findings ambiguous whose interval contains their neutral value, and all findings if the held-out prediction did
// not improve. Applies to reports of any method.
void lower_grades(nlohmann::ordered_json* report);

// Keeps the first entry of `not_identifiable` for each effect and place. Several sets of effects, and several methods, may
// have the same effect.
void list_once(nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
