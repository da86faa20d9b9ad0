// SPDX-License-Identifier: BSD-3-Clause
// Corrects integration errors. Encoders resolve 1e-5 rad, but steps of half a millisecond err by several times that for
// a sticking joint or a heavy arm. Such errors look like missing physics. Finer steps in every rollout would cost too
// much. Their effect hardly depends on the parameters, so it is computed once per hypothesis and added to all rollouts
// near it.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// Factor on the number of steps that shows their errors. Differences of readings do with as many times fewer.
constexpr int kFiner = 4;

// Readings with steps of 1 / `finer` of the problem's, minus readings with its own, for the given recordings from the
// problem's start states. Empty for other recordings and if a rollout fails.
StepErrors estimate_step_errors(const Problem& problem, const Hypothesis& hypothesis,
                                const std::vector<int>& recordings, int finer);

}  // namespace hrp::diagnosis
