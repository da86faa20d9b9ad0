// SPDX-License-Identifier: BSD-3-Clause
// A world with two causes of which one stays unknown: what is known of the other joint is told all the same.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

// The largest fitted set whose effects all are settled, as a part of the explanation; none without one. An effect of a
// joint is settled if the missing torque names it for sure (`found`), and if the set leaves no more than a trace of the
// squares of that joint's held-out signals. Errors of another joint move it, too, so noise is not asked for.
std::optional<Outcome> name_settled_joints(const Problem& problem, const Outcome& outcome,
                                           const std::vector<Finding>& found);

}  // namespace hrp::diagnosis
