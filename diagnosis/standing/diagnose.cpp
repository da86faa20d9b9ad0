// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "diagnosis/report/report.h"
#include "diagnosis/standing/search.h"

namespace hrp::diagnosis::standing {
bool diagnose_standing(const Problem& problem, const std::function<void(const std::string&)>& progress, Reports* out) {
  StandProblems stands;
  std::string why;
  if (!make_stand_problem(*problem.experiment, {Parity::kAll}, &stands.all, &why)) return false;
  make_stand_problem(*problem.experiment, {Parity::kEven}, &stands.even, &why);
  make_stand_problem(*problem.experiment, {Parity::kOdd}, &stands.odd, &why);
  make_stand_problem(*problem.experiment, {Parity::kEven, std::sqrt(2.0)}, &stands.wide_even, &why);
  make_stand_problem(*problem.experiment, {Parity::kOdd, std::sqrt(2.0)}, &stands.wide_odd, &why);
  const StandProblem& stand = stands.all;
  for (StandProblem* half : {&stands.even, &stands.odd, &stands.wide_even, &stands.wide_odd}) {
    // Samples of both halves are multiplied with each other, so all halves keep the same ones.
    for (size_t r = 0; r < stand.recordings.size(); ++r) {
      half->recordings[r].samples = stand.recordings[r].samples;
      half->recordings[r].window = stand.recordings[r].window;
      half->recordings[r].step = stand.recordings[r].step;
    }
  }
  choose_laws(&stands);
  fill_noise(&stands);
  if (progress) progress("standing robot: " + std::to_string(list_channels(stand).size()) + " equations a sample");
  const StandOutcome outcome = search_standing(stands, problem.jobs, progress);
  out->report = make_stand_report(stand, outcome);
  out->series = make_stand_series(stand, outcome);
  out->series["experiment"] = problem.experiment->path;
  for (const std::string& warning : problem.experiment->warnings) out->series["notes"].push_back(warning);
  return true;
}

}  // namespace hrp::diagnosis::standing
