// SPDX-License-Identifier: BSD-3-Clause
// What the effort that is missing at a joint depends on, when no known effect explains it.
#pragma once

#include <vector>

#include "diagnosis/search/fit.h"
#include "diagnosis/search/relation.h"

namespace hrp::diagnosis {

struct Dependence {
  int joint = 0;
  double effort = 0.0;  // [N m] root mean square of what is missing
  Relation relation;    // to position, velocity, direction, load, time, history
};

// Joints whose missing effort stands out, strongest first, at most three, of those that simulation under `base` misses
// most (`left`: what it leaves of the held-out recordings); elsewhere a heavy link's effort is only smoothed a little
// too much. What they follow is learnt on the training recordings and judged on the others.
std::vector<Dependence> find_dependence(const Problem& problem, const Hypothesis& base, const Score& left);

}  // namespace hrp::diagnosis
