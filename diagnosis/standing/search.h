// SPDX-License-Identifier: BSD-3-Clause
// Diagnosis of a standing robot. Hypotheses are fitted to the channels (channels.h) of the training recordings and
// compared on the others. Effects are added one by one while each improves the score enough.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "diagnosis/standing/judge.h"

namespace hrp::diagnosis::standing {

struct StandTrial {
  StandFit fit;  // with the candidate added to the effects so far
  double probability = 0;
};

// Result of the search, with all that the report needs.
struct StandOutcome {
  std::vector<Channel> channels;
  std::vector<double> sigma;  // noise of each channel
  StandFit nominal, chosen;
  std::vector<double> shared;  // by channel [noise]: rms that even and odd samples share
  double widening = 1;         // factor on intervals (Student's t): few stretches determine the deviations
  std::vector<std::vector<StandTrial>> rounds;         // by chosen effect: candidates of its round, best first
  std::vector<std::vector<Effect>> indistinguishable;  // by chosen effect: alternatives that the data allow
  std::vector<Effect> doubtful;                        // found, but not the same in every recording, so not named
  bool mismatch = false, explained = false;
  bool opposite = false;  // two drives lack equal or opposite efforts, as if coupled
  bool coupled = false;   // one spring across two joints explains as much as two
  bool uneven = false;    // dry friction depends on the position
  bool bent = false;      // several effects in one joint leave more than noise
  bool periodic = false;  // the missing effort of a drive is a sinusoid of time
};

using Progress = std::function<void(const std::string&)>;

// Runs the search. `jobs`: threads.
StandOutcome search_standing(const StandProblems& problems, int jobs, const Progress& progress);

// Contents of report.json, and the data of the page's plots.
nlohmann::ordered_json make_stand_report(const StandProblem& problem, const StandOutcome& outcome);
nlohmann::ordered_json make_stand_series(const StandProblem& problem, const StandOutcome& outcome);

}  // namespace hrp::diagnosis::standing
