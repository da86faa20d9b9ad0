// SPDX-License-Identifier: BSD-3-Clause
// A log as a table: one row a sensor sample, columns named as in experiment folders (/joint_states/<joint>/position).
// Commands stand in the row of the instant at which the servo's reference has reached them.
#pragma once

#include <string>
#include <vector>

#include "common/mcap/reader.h"

namespace hrp {

struct LogTable {
  std::vector<std::string> names;         // the first one is "time" [s]
  std::vector<std::vector<double>> rows;  // NaN where there is no value
};

// Throws std::runtime_error when the file is no log of a simulation.
LogTable read_log_table(mcap::Reader* log);

}  // namespace hrp
