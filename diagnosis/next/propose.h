// SPDX-License-Identifier: BSD-3-Clause
// Proposes the next experiment: of many motions, those that are expected to distinguish best between the remaining
// explanations and to narrow uncertain values.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/explanations.h"
#include "diagnosis/next/motions.h"
#include "diagnosis/search/search.h"

namespace hrp::diagnosis {

struct NextOptions {
  std::vector<std::string> limits;  // see limits.h
  double seconds = 10.0;            // duration of a motion
  int count = 2;  // number of motions: the first is for training, the second for validation, and so on
  int jobs = 1;
};

// One explanation against the best one, for a set of motions.
struct Expected {
  std::string label;         // of the rival
  double probability = 0.0;  // that one of the two is rejected after the motion
  double difference = 0.0;   // rms difference [noise] that remains after fitting again
};

// A parameter of the best explanation, with half widths of its 95 % interval. `least`: no tried motion goes
// below it, however often it is repeated.
struct ExpectedInterval {
  std::string label, parameter, unit;
  double value = 0.0, before = 0.0, after = 0.0, least = 0.0;
};

// Predictions of one signal under all explanations.
struct Overlay {
  std::string signal, unit;
  std::vector<double> time;
  std::vector<std::vector<double>> curves;  // by explanation
  std::vector<std::string> labels;          // by curve; empty: those of all explanations
};

struct Proposal {
  std::string file;  // "train_1.csv"
  MotionPlan plan;
  Commands commands;
  std::vector<std::string> moving;
  std::vector<Expected> expected;           // for this motion alone
  std::vector<ExpectedInterval> intervals;  // after this motion and all before it
  Overlay overlay;
  double worth = 0.0;
  std::vector<double> stop;  // by joint [rad or m]: stop if a joint is further from its command; empty: not known
  std::vector<std::vector<double>> effort;  // [N m or N] expected, by joint; empty: a servo follows the commands
};

struct Next {
  std::string nothing;  // reason why no motion is proposed; else empty
  std::vector<std::string> explanations;
  std::vector<Proposal> proposals;        // best first
  std::vector<std::string> remarks;       // limits that are unknown, checks that were not made
  std::vector<std::string> rejected;      // motions that would tell more but are not safe, and why
  std::vector<std::string> words;         // without a motion: which kind of motion would tell, from the report
  std::vector<std::string> untold;        // alternatives that these motions cannot tell apart
  std::string checked;                    // how the motions were checked; empty: simulated under every explanation
  std::string scale = "times the noise";  // unit of Expected::difference
  bool unseen = false;
  int tried = 0;      // number of simulated motions
  int simulated = 0;  // number of simulations on the feet
};

// Proposes motions for the explanations that a report leaves open. Does not write files.
Next propose(const Experiment& experiment, const Json& report, const NextOptions& options, const Progress& progress);

// Proposes motions and writes the files. Returns the proposal as text.
std::string propose_next(const Experiment& experiment, const std::string& folder, const Json& report,
                         const NextOptions& options, const Progress& progress);

// Writes DIR/next/*.csv, next.json and next.html. Removes the files of an earlier proposal there.
void write_next(const Experiment& experiment, const Next& next, const std::string& folder);

}  // namespace hrp::diagnosis
