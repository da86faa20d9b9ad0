// SPDX-License-Identifier: BSD-3-Clause
// Searches the sets of effects that explain the mismatch of the recordings.
#pragma once

#include <functional>

#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {

// Effects of a set: more causes are found one by one around it (additions.h).
constexpr size_t kLargestSet = 3;
constexpr size_t kRivals = 14;  // in the list of an outcome

struct Outcome {
  Trial nominal;    // without effects
  Trial chosen;     // best model; of a partial explanation, the effects of the explained subtrees
  Hypothesis best;  // smallest residual of all simulated sets, explained or not
  bool mismatch = false, explained = false, partly = false;
  bool modelled = false;      // report the chosen model although no effect is named
  bool as_set = false;        // the chosen model comes closest: its effects are ambiguous, as more is left than noise
  bool spent = false;         // the search reached its limit of work
  std::vector<Trial> rivals;  // best first, with the chosen one
  std::vector<Trial> indistinguishable;  // sets that the data cannot distinguish from the chosen one
};

using Progress = std::function<void(const std::string&)>;

// Searches a robot without independent subtrees; search_subtrees() handles the general case.
Outcome search(const Problem& problem, const Progress& progress);

}  // namespace hrp::diagnosis
