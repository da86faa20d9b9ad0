// SPDX-License-Identifier: BSD-3-Clause
// Diagnosis of a tossed body: effects are added one by one while each improves the fit enough.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/toss/fit.h"

namespace hrp::diagnosis::toss {

// A fitted candidate with the results of the tests.
struct TossTrial {
  EffectId added;
  TossFit fit;
  double gain = 0.0;      // reduction of the training cost
  double sureness = 0.0;  // mean gain per toss over its standard error
  bool accepted = false;
  bool doubted = false;  // passes every test, but another cause is possible (TossRow::refused)
  std::string why;       // reason if not accepted
};

// Result of the search, with all that the report needs.
struct TossOutcome {
  TossFit nominal, chosen;
  std::vector<TossTrial> trials;      // all fitted candidates in the order of trying
  std::vector<TossTrial> doubted;     // each fitted beside the chosen effects
  std::map<EffectId, double> shares;  // of the nominal cost, by effect, in the order of adding
  bool mismatch = false, explained = false, partly = false;
};

using TossProgress = std::function<void(const std::string&)>;

// Runs the search. `jobs`: threads.
TossOutcome search_tosses(const TossProblem& problem, int jobs, const TossProgress& progress);

// A problem of at most about `most_windows` windows: an even selection of tosses of both roles. `other`: as many other
// tosses; without windows if there are none.
TossProblem make_small_problem(const TossProblem& problem, size_t most_windows, bool other = false);

// Contents of report.json, and the data of the page's plots.
nlohmann::ordered_json make_toss_report(const TossProblem& problem, const TossOutcome& outcome);
nlohmann::ordered_json make_toss_series(const TossProblem& problem, const TossOutcome& outcome);

// Diagnoses a tossed body: a floating base without joints, with recorded pose, above a ground. Returns false for other
// recordings, with the reason in `why`; else fills report.json and series.json.
bool diagnose_toss(const Experiment& experiment, int jobs, const TossProgress& progress, nlohmann::ordered_json* report,
                   nlohmann::ordered_json* series, std::string* why);

}  // namespace hrp::diagnosis::toss
