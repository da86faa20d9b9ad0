// SPDX-License-Identifier: BSD-3-Clause
// From the tosses of a body to a verdict: effects are added one by one while they earn their place.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/toss/fit.h"

namespace hrp::diagnosis::toss {

struct TossTrial {
  EffectId added;
  TossFit fit;
  double gain = 0.0;       // of the cost, training recordings
  double sureness = 0.0;   // mean gain of a toss over the standard error of that mean
  bool consistent = true;  // both halves of the tosses give the same parameters
  bool accepted = false;
  bool doubted = false;    // passes every test, but another cause may do the same (TossRow::refused)
  std::string why;  // not accepted
};

struct TossOutcome {
  TossFit nominal, chosen;
  std::vector<TossTrial> trials;  // all that were fitted, in the order of trying
  std::vector<TossTrial> doubted;  // beside what was chosen, one by one
  std::map<EffectId, double> shares;  // of the nominal model's cost, by effect in the order of adding
  bool mismatch = false, explained = false, partly = false;
  double flight = 0.0;  // score of windows without contact, as it is left
};

using TossProgress = std::function<void(const std::string&)>;
TossOutcome search_tosses(const TossProblem& problem, int jobs, const TossProgress& progress);

// A problem small enough for the search: an even choice of tosses, both roles. `other`: as many again that are not in
// the first choice; without windows when all are.
TossProblem make_small_problem(const TossProblem& problem, size_t most_windows, bool other = false);

nlohmann::ordered_json make_toss_report(const TossProblem& problem, const TossOutcome& outcome);
nlohmann::ordered_json make_toss_series(const TossProblem& problem, const TossOutcome& outcome);

// Tossed bodies: a floating base without joints, its pose recorded, over a ground. False when these recordings are not
// that; else the contents of report.json and series.json.
bool diagnose_toss(const Experiment& experiment, int jobs, const TossProgress& progress,
                     nlohmann::ordered_json* report, nlohmann::ordered_json* series);

}  // namespace hrp::diagnosis::toss
