// SPDX-License-Identifier: BSD-3-Clause
// Chooses the model for `updated/`: of several models of a fixed-base robot, the one that predicts held-out recordings
// best.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "diagnosis/estimate/at_rest.h"
#include "diagnosis/search/trial.h"
#include "diagnosis/simulation/windows.h"

namespace hrp::diagnosis {

// True for the standard deviation [rad, m] of a position that is compared: its range, were it uniform, is a motion.
// Where a joint comes to rest that hardly moves, its dry friction decides, which its recorded rest does not tell: its
// error over its spread has no bound.
inline bool does_move(double spread) { return std::sqrt(12.0) * spread > kHardlyMoved; }

// Simulates a hypothesis and scores it on the training and on the held-out recordings.
Trial simulate_trial(const Problem& problem, const Hypothesis& hypothesis);

// Why an effect that `named` does not have is hardly possible on this robot; empty if all are possible.
std::string find_odd_effect(const Experiment& e, const Hypothesis& model, const Hypothesis& named);

// Errors of free simulations over short windows of held-out recordings. For robots that are driven by recorded efforts.
WindowErrors calc_held_windows(const Problem& problem, const Hypothesis& hypothesis);

// Returns the candidate with the lowest cost on held-out recordings. No parameter is fitted to them. The candidates
// are:
//
// - `model`, fitted to the missing torque, and the same with parameters fitted through simulation;
// - plain least squares of friction and rotors, with and without gear losses, and the same fitted through simulation;
// - `searched`, the result of the search, alone and beside friction and rotors; empty if the search found nothing;
// - the best of these with richer laws, and each joint with the laws of the candidate that is best there.
//
// `explained` [1] is the share of the held-out missing torque (of its squares) that `model` predicts. Where hardly a
// trace of it is left, fits from plain least squares and to positions alone are not tried. They take half of the time,
// and start further away. `problem` searches by subtrees; `whole` is the problem of the whole robot. `progress` gets
// one line per candidate.
Trial choose_best_model(const Problem& problem, const Problem& whole, const Hypothesis& model, double explained,
                        const Hypothesis& searched, const std::function<void(const std::string&)>& progress);

}  // namespace hrp::diagnosis
