// SPDX-License-Identifier: BSD-3-Clause
// Finds what the missing effort of a joint depends on if no known effect explains it.
#pragma once

#include <vector>

#include "diagnosis/search/fit.h"
#include "diagnosis/search/relation.h"

namespace hrp::diagnosis {

// What the missing effort of one joint depends on.
struct Dependence {
  int joint = 0;
  double effort = 0.0;  // [N m] rms of the missing effort
  Relation relation;    // dependence on position, velocity, direction, load, time, history
};

// Returns at most three joints with a significant missing effort, strongest first. Only joints that the simulation
// under `base` predicts badly count (`left`: its score on held-out recordings); at others, smoothing alone may distort
// the effort of a heavy link. Relations are learnt on training recordings and judged on held-out ones.
std::vector<Dependence> find_dependence(const Problem& problem, const Hypothesis& base, const Score& left);

}  // namespace hrp::diagnosis
