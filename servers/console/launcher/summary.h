// SPDX-License-Identifier: BSD-3-Clause
// The words at the end of a run.
#pragma once

#include <string>

#include "servers/console/launcher/run_set.h"

namespace hrp {

// "logs/SCENARIO-YYYYMMDD-HHMMSS.mcap" under the working folder, unless the command line or the scenario name a file.
// Makes the folder. Throws InputError when that fails.
std::string choose_log_file(const LaunchOptions& options, const Scenario& scenario);

// Reads the log and says where it is, up to which step it is complete, and the hash of the last state.
void print_summary(const LaunchOptions& options, const RunOutcome& outcome, const std::string& log);

}  // namespace hrp
