// SPDX-License-Identifier: BSD-3-Clause
// One self-contained page: table 1 (K, C, O), tables 2 and 3 (direct and cross validation), plots in the form of figures
// 4, 6 and 7 to 13 of [M14], and the scenario with the bush that was found.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/identification/bush_fit.h"

namespace hrp::identification {

struct Identification {
  Scenario scenario;
  bool simulated = true;
  std::vector<MotionTrack> tracks;       // all that could be used
  std::vector<bool> train;               // by track: fitted, else only predicted
  BushFit fit;
  LawChoice choice;
  std::vector<ValidationError> direct;   // motions that were fitted
  std::vector<ValidationError> cross;    // each motion predicted by a fit that has not seen it
  std::vector<Estimate> compliance;      // [m/N] vertical, by foot
  std::vector<std::string> notes;        // what was left out and why
};

// Fits, chooses the law, validates.
Identification identify(const Scenario& scenario, const std::vector<MotionTrack>& tracks, const std::vector<bool>& train,
                        const std::vector<SensorZero>& zeros, const std::vector<MotionTrack>& resting);

// The places of the bushes' centres in their feet, as the observer uses them.
std::string write_identified_scenario(const Identification& result, const std::string& folder);
void write_report(const Identification& result, const std::string& path);
// The same numbers for the terminal.
std::string make_text(const Identification& result);

}  // namespace hrp::identification
