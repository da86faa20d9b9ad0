// SPDX-License-Identifier: BSD-3-Clause
// Reduces the weight of readings while a drive is at its limit. No feedback acts then. Integrators, or a law and a
// robot, differ by a thousandth of the acceleration. This moves the joint until the pull of rollout.h balances it, by
// much more than an encoder resolves.
#pragma once

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// Factors (at most 1) of the weights of one recording, in the order of the readings; empty if no drive reaches its
// limit. They do not depend on a hypothesis.
std::vector<float> find_trust(const Problem& problem, size_t recording);

}  // namespace hrp::diagnosis
