// SPDX-License-Identifier: BSD-3-Clause
// Lists terms that are not in the best model but may exist. A little noise can change which of several models is best.
// The probability of a family over all models is more stable.
#pragma once

#include "diagnosis/evidence/torque/grade.h"

namespace hrp::diagnosis {

// Returns ambiguous terms that are not in the model: at most one per family and place, and only if the family is
// neither in the model nor among its rivals.
std::vector<GradedTerm> list_possible_terms(const TorqueDesign& design, const Choice& choice,
                                            const std::vector<GradedTerm>& graded, int jobs);

}  // namespace hrp::diagnosis
