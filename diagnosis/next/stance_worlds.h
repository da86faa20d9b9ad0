// SPDX-License-Identifier: BSD-3-Clause
// Possible explanations of a standing robot, as scenarios that can be simulated.
#pragma once

#include <string>
#include <vector>

#include "common/robot/scenario.h"
#include "diagnosis/next/stance_logs.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

// One value changed by its step.
struct StanceMove {
  int shared = -1;      // index of the same move of the report's model, which stands for this one; -1: none
  bool of_log = false;  // only `faults` change
  Scenario scenario;    // if not shared
  std::vector<LogFault> faults;
};

struct StanceWorld {
  std::string label;
  Scenario scenario;
  std::vector<StanceMove> moves;
  std::vector<LogFault> faults;  // of what the robot writes
};

// A parameter of the report's model.
struct StanceValue {
  std::string label, parameter, unit;
  double value = 0.0, std = 0.0;  // std 0: unknown
};

struct StanceWorlds {
  std::vector<StanceWorld> list;     // the report's model first, then with each alternative in its finding's place
  std::vector<StanceValue> values;   // by list[0].moves: the least certain ones
  std::vector<StanceWorld> ends;     // further cases for safety: nominal; values at either end of their intervals
  std::vector<std::string> remarks;  // alternatives that no simulator knows
  bool unseen = false;               // no mismatch: the others are what joints that hardly moved may hide
  bool still = false;                // a joint that carries no foot hardly moved
  bool open = false;                 // the report names something, or cannot explain something
};

// Converts a report's model and its alternatives to scenarios.
StanceWorlds make_stance_worlds(const Experiment& experiment, const Json& report);

}  // namespace hrp::diagnosis
