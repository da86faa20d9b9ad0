// SPDX-License-Identifier: BSD-3-Clause
// Multiple shooting: a model simulated over many short windows, each from the recorded state at its begin. A simulation
// from measured efforts drifts within seconds, whatever the model; within half a second it says how good the model is.
#pragma once

#include <vector>

#include "diagnosis/simulation/rollout.h"

namespace hrp::diagnosis {

// [s] of a window: longer than a reversal, shorter than what a small error takes to grow.
constexpr double kWindow = 0.5;
constexpr int kMostWindows = 400;

struct WindowErrors {
  int windows = 0;           // that stayed finite in the model
  std::vector<double> rms;   // by joint, of simulated less recorded position [rad or m]; NaN without positions
};

// Root mean squares over windows of `recordings`, one after another without a gap between them; evenly chosen ones where
// there are more than kMostWindows. A window in which the model blows up counts as an error of one turn.
WindowErrors calc_window_errors(const Plant& plant, const Experiment& experiment,
                                const std::vector<SmoothRecording>& smooth, const std::vector<int>& recordings, int jobs);

// Readings of a recording, [sample][joint * 3 + quantity], simulated over its windows; as recorded between and before them.
// False where a window leaves the finite numbers.
bool simulate_windows(const Plant& plant, const Experiment& experiment, const SmoothRecording& smooth, int recording,
                      std::vector<double>* readings);

}  // namespace hrp::diagnosis
