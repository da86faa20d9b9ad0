// SPDX-License-Identifier: BSD-3-Clause
// What the recordings leave open: explanations that predict them about as well as the best one.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/report/json.h"
#include "diagnosis/search/problem.h"
#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

struct Explanation {
  Hypothesis hypothesis;
  std::string label;
  double cost = 0.0;   // sum of squares over the noise, along the recorded paths
  bool listed = false; // the report lists it as an alternative
};

struct Explanations {
  std::vector<Explanation> list;  // the best first; a single one: nothing is ambiguous
  double discrepancy = 1.0;       // what the best leaves of the recordings [noise deviations], at least 1
  bool unseen = false;            // nothing was found; the others are what too weak a motion would hide
};

// Of all joints and recordings.
double count_readings(const Problem& problem);

// An effect as a report has it; false where no simulator knows it, or its place is not of this robot.
bool read_effect(const Experiment& experiment, const Json& entry, Effect* effect);

// The best model of a report.
Hypothesis read_model(const Experiment& experiment, const Json& report);

// Needs the problem's nominal paths. Every finding is taken out of the best model in turn, and whatever does as well in
// its place is a rival, whether the report lists it or not.
Explanations find_explanations(const Problem& problem, const Json& report, const Progress& progress);

}  // namespace hrp::diagnosis
