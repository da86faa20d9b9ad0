// SPDX-License-Identifier: BSD-3-Clause
// From the recordings of a standing robot to a verdict: hypotheses are fitted to the channels (stand_channels.h) of the
// training recordings, compared on the others, and added one by one while they earn their place.
#pragma once

#include <functional>

#include <nlohmann/json.hpp>

#include "diagnosis/upright_channels.h"

namespace hrp::diagnosis::upright {

// How an effect is written, started and varied.
struct StandInfo {
  StandId id;
  const char* effect;                    // name in the report
  std::vector<const char*> parameters;   // names; "" is a nuisance
  std::vector<const char*> units;
  std::vector<double> neutral;           // value that changes nothing
  std::vector<double> step;              // for finite differences
  bool positive = false;                 // first parameter must not fall below its neutral value
};
const StandInfo& get_stand_info(StandId id);

struct StandFit {
  StandHypothesis hypothesis;
  std::vector<Eigen::VectorXd> std;     // by effect, by parameter
  Eigen::MatrixXd covariance;           // of all parameters in a row
  std::vector<double> channel_rms;      // whitened, on the recordings that were not fitted
  double score = 0;                     // sum over channels of n log(rms^2), not below the noise; lower is better
};

struct StandTrial {
  StandFit fit;          // with the candidate added to what was there
  StandEffect added;
  double probability = 0;
};

struct StandOutcome {
  std::vector<Channel> channels;
  std::vector<double> sigma;                     // of each channel
  StandFit nominal, chosen;
  std::vector<std::vector<StandTrial>> rounds;   // best first; what was tried beside each accepted effect
  bool mismatch = false, explained = false;
};

using Progress = std::function<void(const std::string&)>;
StandOutcome search_standing(const StandProblem& problem, int jobs, const Progress& progress);

// report.json of the outcome (schema 1), and what the page's plots need.
nlohmann::ordered_json make_stand_report(const StandProblem& problem, const StandOutcome& outcome);
nlohmann::ordered_json make_stand_series(const StandProblem& problem, const StandOutcome& outcome);

}  // namespace hrp::diagnosis::upright
