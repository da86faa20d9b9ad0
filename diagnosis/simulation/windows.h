// SPDX-License-Identifier: BSD-3-Clause
// Multiple shooting: simulates a model over many short windows, each from the recorded state at its start. A simulation
// from measured efforts drifts away within seconds, even with a good model. Within half a second its error shows how
// good the model is.
#pragma once

#include <vector>

#include "diagnosis/simulation/rollout.h"

namespace hrp::diagnosis {

// [s] Length of a window: longer than a reversal, shorter than the time in which a small error grows large.
constexpr double kWindow = 0.5;
constexpr int kMostWindows = 400;  // evenly chosen, as each costs a simulation

struct WindowErrors {
  int windows = 0;          // whose simulation stayed finite
  std::vector<double> rms;  // by joint, of simulated minus recorded position [rad or m]; NaN without positions
};

// Root mean squares over consecutive windows of `recordings` without gaps; over evenly selected ones if there are more
// than kMostWindows. A window whose simulation becomes infinite counts as an error of one turn.
WindowErrors calc_window_errors(const Plant& plant, const Experiment& experiment,
                                const std::vector<SmoothRecording>& smooth, const std::vector<int>& recordings,
                                int jobs);

// Readings of a recording, [sample][joint * 3 + quantity], simulated in its windows and as recorded outside of them.
// Returns false if a simulation becomes infinite.
bool simulate_windows(const Plant& plant, const Experiment& experiment, const SmoothRecording& smooth, int recording,
                      std::vector<double>* readings);

}  // namespace hrp::diagnosis
