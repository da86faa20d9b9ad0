// SPDX-License-Identifier: BSD-3-Clause
// Errors of the integrator's steps. Encoders resolve 1e-5 rad, and a simulation in steps of half a millisecond misses a
// joint that sticks, or a heavy arm's effort, by several times that: such errors look like missing physics. Finer steps
// in every rollout of every fit would cost too much; but what they change hardly depends on the parameters, so it is
// computed for the hypothesis at hand once and added to what all rollouts near it read.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// Readings in steps of 1 / `finer` of the problem's less readings in its own, for the given recordings under a
// hypothesis from the problem's starts; empty elements for all others, and where a rollout fails.
StepErrors estimate_step_errors(const Problem& problem, const Hypothesis& hypothesis,
                                const std::vector<int>& recordings, int finer);

}  // namespace hrp::diagnosis
