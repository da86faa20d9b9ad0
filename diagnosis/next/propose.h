// SPDX-License-Identifier: BSD-3-Clause
// The next experiment: of many motions those that are expected to tell most between the explanations that recordings
// leave open, and of values that are uncertain.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/explanations.h"
#include "diagnosis/next/motions.h"
#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

struct NextOptions {
  std::vector<std::string> limits;  // see limits.h
  double seconds = 10.0;            // of a motion
  int count = 2;                    // motions: the first to fit to, the second to judge on, and so on
  int jobs = 1;
};

// One explanation against the best, for a set of motions.
struct Expected {
  std::string label;           // of the rival
  double probability = 0.0;    // that one of the two is given up after the motion
  double difference = 0.0;     // [noise deviations] root mean square that stays after fitting again
};

// A value of the best explanation, half widths of its 95 % interval.
struct ExpectedInterval {
  std::string label, parameter, unit;
  double value = 0.0, before = 0.0, after = 0.0;
};

// Predictions of one signal under every explanation.
struct Overlay {
  std::string signal, unit;
  std::vector<double> time;
  std::vector<std::vector<double>> curves;  // by explanation
};

struct Proposal {
  std::string file;        // "train_1.csv"
  MotionPlan plan;
  Commands commands;
  std::vector<std::string> moving;
  std::vector<Expected> expected;             // of this motion alone
  std::vector<ExpectedInterval> intervals;    // after this motion and those before it
  Overlay overlay;
  double worth = 0.0;
  std::vector<double> stop;  // by joint [rad or m]: a robot whose joint is further from its command should stop
};

struct Next {
  std::string nothing;                  // why no motion is proposed; else empty
  std::vector<std::string> explanations;
  std::vector<Proposal> proposals;      // best first
  std::vector<std::string> remarks;     // limits that are not known, checks that were not made
  std::vector<std::string> rejected;    // motions that tell more but are not safe, and why
  bool unseen = false;
  int tried = 0;                        // motions that were simulated
};

Next propose(const Experiment& experiment, const Json& report, const NextOptions& options, const Progress& progress);

// Proposes and writes; what was proposed, as text.
std::string propose_next(const Experiment& experiment, const std::string& folder, const Json& report, const NextOptions& options,
                         const Progress& progress);

// DIR/next/*.csv, next.json and next.html. Removes what a proposal before it left there.
void write_next(const Experiment& experiment, const Next& next, const std::string& folder);

}  // namespace hrp::diagnosis
