// SPDX-License-Identifier: BSD-3-Clause
// Converts graded terms to findings, to effects of a simulation, and to sentences.
#pragma once

#include <optional>

#include "diagnosis/evidence/coupled_drives.h"
#include "diagnosis/evidence/torque/grade.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// `excess`: the Stribeck term beside a dry friction, or null. `alternatives`: come before the term's rivals.
Finding make_finding(const Experiment& experiment, const GradedTerm& term, const GradedTerm* excess,
                     const std::vector<Alternative>& alternatives);
// Empty if the simulator has no law for the term.
std::optional<Effect> make_effect(const GradedTerm& term, const GradedTerm* excess);

// A term that improves the prediction but is not named, with the reason.
NotIdentifiable make_detail(const Experiment& experiment, const GradedTerm& term);

// "dry friction of 1.2 N m at the rate of wrist plus 1 times that of elbow: ...".
std::string make_coupled_words(const Experiment& experiment, int joint, const CoupledDrives& coupled);

// Sentence on the missing torque of a joint and on what remains. `follows`: what it depends on; may be empty.
std::string make_remaining_words(const Experiment& experiment, int joint, const Remaining& remaining,
                                 const std::string& follows);

}  // namespace hrp::diagnosis
