// SPDX-License-Identifier: BSD-3-Clause
// Explanations that predict the recordings about as well as the best one.
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
  double cost = 0.0;    // sum of squares in units of noise, along the recorded paths
  bool listed = false;  // the report lists it as an alternative
};

struct Explanations {
  std::vector<Explanation> list;  // the best one first; a single one: nothing is ambiguous
  double discrepancy = 1.0;       // rms residual [noise] of the best one, at least 1
  bool unseen = false;            // no effect was found; the others are what too weak a motion would hide
};

// Number of readings of all joints in all recordings.
double count_readings(const Problem& problem);

// Dry friction that a joint may hide as long as it does not move: a small part of its largest effort. Empty without
// such a limit.
Hypothesis make_hidden_friction(const Experiment& experiment, int joint);

// Converts an effect of a report; false if no simulator knows it or the robot does not have its place.
bool read_effect(const Experiment& experiment, const Json& entry, Effect* effect);

// The best model of a report.
Hypothesis read_model(const Experiment& experiment, const Json& report);

// Requires the problem's nominal paths. Each finding is removed from the best model in turn. Whatever fits as well in
// its place is a rival, whether the report lists it or not.
Explanations find_explanations(const Problem& problem, const Json& report, const Progress& progress);

}  // namespace hrp::diagnosis
