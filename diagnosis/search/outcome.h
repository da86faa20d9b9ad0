// SPDX-License-Identifier: BSD-3-Clause
// Which of the sets that a search has fitted is named, with its rivals and intervals.
#pragma once

#include "diagnosis/search/trials.h"

namespace hrp::diagnosis {

struct Searched {
  const Experiment& experiment;
  const Problem& problem;
  const std::vector<Trial>& passed_over;  // sets that were judged along recorded paths only
  const Progress& progress;
};

// Fills in the best set, and the simplest one that held-out recordings cannot distinguish from it, without effects that
// are not significant.
void choose_outcome(const Searched& searched, Trials* trials, Outcome* outcome);

// Where nothing is explained: the smallest set of one to three effects that takes nearly all of the held-out error
// (kNearlyAll), by simulation, and more than noise is left. Of several that do as well, the one with fewest parameters.
// Null if there is none.
const Trial* find_closest(const Outcome& outcome);
// The same where it can be told: with held-out recordings, and not from recorded efforts, whose simulation drifts.
const Trial* find_told_closest(const Problem& problem, const Outcome& outcome);
// Sets of as many effects that come about as close, best first.
std::vector<const Trial*> list_as_close(const Outcome& outcome, const Trial& closest);

}  // namespace hrp::diagnosis
