// SPDX-License-Identifier: BSD-3-Clause
// Of several models of a robot on a fixed base the one that predicts held-out recordings best: what `updated/` gets.
#pragma once

#include <functional>
#include <string>

#include "diagnosis/search/trial.h"
#include "diagnosis/simulation/windows.h"

namespace hrp::diagnosis {

// A hypothesis as it predicts training and held-out recordings.
Trial simulate_trial(const Problem& problem, const Hypothesis& hypothesis);

// Free simulation of short windows of held-out recordings, for recorded efforts.
WindowErrors calc_held_windows(const Problem& problem, const Hypothesis& hypothesis);

// Candidates: `model`, of the missing torque; plain least squares; both fitted to simulated positions and to efforts at
// once; and what a search found, empty if nothing, alone and beside friction and rotors. Nothing is fitted to held-out
// recordings. `whole`: the problem by subtrees.
Trial choose_best_model(const Problem& problem, const Problem& whole, const Hypothesis& model, const Hypothesis& searched,
                        const std::function<void(const std::string&)>& progress);

}  // namespace hrp::diagnosis
