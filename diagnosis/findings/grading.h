// SPDX-License-Identifier: BSD-3-Clause
// Grades by what a report says as a whole.
#pragma once

#include "diagnosis/findings/finding.h"

namespace hrp::diagnosis {

// Share of the squares above the noise that findings remove: of held-out recordings, or of all if none is held out.
double calc_explained(const Fit& fit);

// The report of a search for single effects; fills `explained` and `ceiling`. Findings that are not ambiguous already
// are certain; supported without held-out recordings or unless all is explained; ambiguous if they remove nothing, if
// an interval contains the neutral value, or if another family fits as well.
nlohmann::ordered_json make_graded_report(bool has_held, Evidence evidence);

// Whether a finding's interval has this value in it; false for what is no interval.
bool holds(const nlohmann::ordered_json& interval, double value);

// True if the interval of a parameter contains its neutral value, at which the effect is absent.
bool may_be_absent(const nlohmann::ordered_json& finding);

// A number of a finding's parameters, by its name in a report; `missing` where the finding does not say.
double read_number(const nlohmann::ordered_json& parameters, const char* name, double missing);

// Sets the grade `ambiguous`, also in the statement.
void make_ambiguous(nlohmann::ordered_json* finding);
bool is_ambiguous(const nlohmann::ordered_json& finding);

// Whether two findings, or alternatives of findings, are of one effect at one place.
bool is_same_effect(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);

// A finding as an alternative of another one.
nlohmann::ordered_json state_as_alternative(const nlohmann::ordered_json& finding);

// For simulations without held-out recordings: makes findings ambiguous that the missing torque does not support at the
// same place, and adds its alternatives.
void doubt_unconfirmed(const std::vector<Finding>& torque, nlohmann::ordered_json* report);

// Makes findings ambiguous whose interval contains their neutral value, and all findings if the held-out prediction did
// not improve. Applies to reports of any method.
void lower_grades(nlohmann::ordered_json* report);

// Keeps the first entry of `not_identifiable` for each effect and place. Several sets of effects, and several methods,
// may have the same effect.
void list_once(nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
