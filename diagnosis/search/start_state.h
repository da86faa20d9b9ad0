// SPDX-License-Identifier: BSD-3-Clause
// Estimates the state in which the simulation of a recording starts. The smoothed readings are only approximate:
// smoothing rounds a sudden start, and no encoder measures the link behind an elastic transmission. A wrong start state
// rings as long as the transmission does and looks like missing physics.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// Corrections of the smoothed start state of the given recordings under a hypothesis. They are least-squares fits to
// the samples before the judged ones. Empty for other recordings and if a rollout fails. Start states are no model
// parameters, so held-out recordings have their own.
Starts estimate_starts(const Problem& problem, const Hypothesis& hypothesis, const std::vector<int>& recordings);

}  // namespace hrp::diagnosis
