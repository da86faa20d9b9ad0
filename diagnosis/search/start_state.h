// SPDX-License-Identifier: BSD-3-Clause
// Where the simulation of a recording begins. The smoothed readings give it only roughly: smoothing rounds off a motion
// that starts sharply, and no encoder sees the link behind an elastic transmission. An error there rings for as long as
// the transmission does and would be taken for missing physics, so the state is estimated from what follows.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// Corrections of the smoothed state at the begin of the given recordings under a hypothesis, by least squares over the
// samples before those that are judged; empty elements for all other recordings, and where a rollout fails. They are
// states, no parameters of a model: recordings that nothing is fitted to have theirs, too.
Starts estimate_starts(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings);

}  // namespace hrp::diagnosis
