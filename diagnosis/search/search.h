// SPDX-License-Identifier: BSD-3-Clause
// From recordings to a verdict: which effects, if any, explain the mismatch.
#pragma once

#include <functional>

#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {

struct Outcome {
  Trial nominal;  // nothing added
  Trial chosen;   // best model found; of a partial explanation the effects of those subtrees that are explained
  Hypothesis best;  // what left least of all that was tried through the simulation, explained or not
  bool mismatch = false, explained = false, partly = false;
  bool modelled = false;          // the chosen model is to be shown, though nothing in it is named
  bool spent = false;             // the search ended at its limit of work
  std::vector<Trial> rivals;      // best first, the chosen one too
  std::vector<Trial> indistinguishable;  // as good as the chosen one: the data cannot tell
};

using Progress = std::function<void(const std::string&)>;

Outcome search(const Problem& problem, const Progress& progress);

}  // namespace hrp::diagnosis
