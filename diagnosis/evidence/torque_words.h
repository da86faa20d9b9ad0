// SPDX-License-Identifier: BSD-3-Clause
// Graded terms as findings, effects of a simulation, and sentences.
#pragma once

#include <optional>

#include "diagnosis/findings/finding.h"
#include "diagnosis/evidence/torque_grade.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// `excess`: the Stribeck term of a dry friction, or null; `alternatives`: alternatives beside those that do as well.
Finding make_finding(const Experiment& experiment, const GradedTerm& term, const GradedTerm* excess,
                     const std::vector<Alternative>& alternatives);
// Nothing where the simulator has no law for it.
std::optional<Effect> make_effect(const GradedTerm& term, const GradedTerm* excess);
NotIdentifiable make_detail(const Experiment& experiment, const GradedTerm& term);

std::string make_remaining_words(const Experiment& experiment, int joint, const Remaining& remaining,
                                 const std::string& follows);

}  // namespace hrp::diagnosis
