// SPDX-License-Identifier: BSD-3-Clause
// What a standing robot may be, as scenarios that can be simulated.
#pragma once

#include <string>
#include <vector>

#include "common/robot/scenario.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

struct StanceWorld {
  std::string label;
  Scenario scenario;
  std::vector<Scenario> moved;   // with one value after the other moved by its step
};

// A value of the report's model.
struct StanceValue {
  std::string label, parameter, unit;
  double value = 0.0, std = 0.0;  // std 0: nothing is known of it
};

struct StanceWorlds {
  std::vector<StanceWorld> list;     // the report's model first, then with each alternative in its finding's place
  std::vector<StanceValue> values;   // by list[0].moved
  std::vector<StanceWorld> ends;     // to be safe under, too: nominal; every value at either end of its interval
  std::vector<std::string> remarks;  // alternatives that no simulator knows
};

StanceWorlds make_stance_worlds(const Experiment& experiment, const Json& report);

}  // namespace hrp::diagnosis
