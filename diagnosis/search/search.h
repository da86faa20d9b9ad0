// SPDX-License-Identifier: BSD-3-Clause
// From recordings to a verdict: which effects, if any, explain the mismatch.
#pragma once

#include <functional>

#include "diagnosis/search/trial.h"

namespace hrp::diagnosis {

struct Outcome {
  Trial nominal;  // nothing added
  Trial chosen;   // best model found, named or not
  bool mismatch = false, explained = false, partly = false;
  bool spent = false;             // the search ended at its limit of work
  bool modelled = false;          // the chosen model predicts better, though nothing in it is certain
  std::vector<Trial> rivals;      // best first, the chosen one too
  std::vector<Hypothesis> twins;  // as good as the chosen one: the data cannot tell
  // Of a partial explanation, by effect of the chosen model (empty: all are findings): by what factor the held-out
  // error of its joint grows without it (infinite: its subtree is explained), 0 where it only helps to predict, and why it
  // is not certain then.
  std::vector<double> worth;
  std::vector<std::string> doubts;
};

using Progress = std::function<void(const std::string&)>;

Outcome search(const Problem& problem, const Progress& progress);

}  // namespace hrp::diagnosis
