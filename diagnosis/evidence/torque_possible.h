// SPDX-License-Identifier: BSD-3-Clause
// Terms that are not in the best model and may still be there: which of several models is best changes with a little
// noise, the probability of what they have in common does not.
#pragma once

#include "diagnosis/evidence/torque_grade.h"

namespace hrp::diagnosis {

// Ambiguous, one of each family and place that neither the model nor a rival of its terms has. None of them is in the
// model.
std::vector<GradedTerm> list_possible_terms(const TorqueDesign& design, const Choice& choice,
                                            const std::vector<GradedTerm>& graded, int jobs);

}  // namespace hrp::diagnosis
