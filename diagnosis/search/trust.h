// SPDX-License-Identifier: BSD-3-Clause
// How far readings can be trusted of a joint whose drive is at its limit. Nothing holds it there: a thousandth of its
// acceleration, which is what integrators, and a law and its robot, differ by, carries it off until the pull of
// rollout.h balances that. Encoders resolve far less.
#pragma once

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// Factors of the weights of one recording's readings, laid out as these, at most 1; empty where no drive comes to its
// limit. What a hypothesis predicts has no part in them.
std::vector<float> find_trust(const Problem& problem, size_t recording);

}  // namespace hrp::diagnosis
