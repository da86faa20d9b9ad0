// SPDX-License-Identifier: BSD-3-Clause
// From the recordings of a standing robot to a verdict: hypotheses are fitted to the channels (channels.h) of
// the training recordings, compared on the others, and added one by one while they earn their place.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "diagnosis/standing/judge.h"

namespace hrp::diagnosis::standing {

struct StandTrial {
  StandFit fit;  // with the candidate added to what was there
  double probability = 0;
};

struct StandOutcome {
  std::vector<Channel> channels;
  std::vector<double> sigma;  // of each channel
  StandFit nominal, chosen;
  std::vector<double> shared;                   // [noise deviations] by channel what even and odd samples share
  double widening = 1;                          // of intervals, because so few stretches tell the deviations
  std::vector<std::vector<StandTrial>> rounds;  // by chosen effect, best first: what was tried in its place
  std::vector<std::vector<Effect>> indistinguishable;  // by chosen effect: what the data cannot tell from it
  std::vector<Effect> doubtful;            // found, but not the same in every recording: not named
  bool mismatch = false, explained = false;
  bool opposite = false;  // two drives lack equal or opposite efforts: something couples them
  bool coupled = false;   // one spring across two joints explains what two springs do
  bool uneven = false;    // dry friction follows the position
  bool bent = false;      // several effects in one joint leave more than noise
  bool periodic = false;  // what a drive lacks is a sinusoid of time
};

using Progress = std::function<void(const std::string&)>;
StandOutcome search_standing(const StandProblems& problems, int jobs, const Progress& progress);

// report.json of the outcome (schema 1), and what the page's plots need.
nlohmann::ordered_json make_stand_report(const StandProblem& problem, const StandOutcome& outcome);
nlohmann::ordered_json make_stand_series(const StandProblem& problem, const StandOutcome& outcome);

}  // namespace hrp::diagnosis::standing
