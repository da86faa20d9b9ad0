// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/step_error.h"

namespace hrp::diagnosis {

StepErrors estimate_step_errors(const Problem& problem, const Hypothesis& hypothesis,
                                const std::vector<int>& recordings, int finer) {
  const Plant plant = make_plant(*problem.experiment, hypothesis);
  StepErrors errors(problem.experiment->recordings.size());
  std::vector<std::vector<double>> coarse(recordings.size()), fine(recordings.size());
  std::vector<char> ok(2 * recordings.size(), 0);
  parallel_for(problem.jobs, static_cast<int>(ok.size()), [&](int task) {
    const size_t i = static_cast<size_t>(task) / 2, r = static_cast<size_t>(recordings[i]);
    const bool is_fine = task % 2 == 0;
    RolloutOptions options = problem.options;
    if (is_fine) options.max_step /= finer;
    const StartState* start = r < problem.starts.size() ? &problem.starts[r] : nullptr;
    const Recording& recording = problem.experiment->recordings[r];
    ok[static_cast<size_t>(task)] = simulate_recording(add_by_hand(plant, recording.spec), recording, problem.smooth[r],
                                                       options, is_fine ? &fine[i] : &coarse[i], start);
  });
  for (size_t i = 0; i < recordings.size(); ++i) {
    if (!ok[2 * i] || !ok[2 * i + 1]) continue;
    for (size_t k = 0; k < fine[i].size(); ++k) fine[i][k] -= coarse[i][k];
    errors[static_cast<size_t>(recordings[i])] = std::move(fine[i]);
  }
  return errors;
}

}  // namespace hrp::diagnosis
