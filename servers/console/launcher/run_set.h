// SPDX-License-Identifier: BSD-3-Clause
// One run: as separate processes, or all in this one. Both return an exit code and leave the log behind.
#pragma once

#include <memory>
#include <string>

#include "common/robot/scenario.h"
#include "servers/console/launcher/options.h"

namespace hrp {

class Children;

struct RunOutcome {
  int exit_code = 0;
  std::string failure;               // empty: ended as planned
  double wall_time = 0.0;            // [s] from the first step to the last
  std::vector<double> parts;         // [s] simulated time of each epoch: a reset begins another one
  std::vector<std::string> logs;     // files that were written, as the logger said
  std::shared_ptr<Children> viewer;  // goes on with the log when the run is over; none unless asked for
};

RunOutcome run_as_processes(const LaunchOptions& options, const Scenario& scenario, const std::string& log);
RunOutcome run_in_this_process(const LaunchOptions& options, const Scenario& scenario, const std::string& log);

// On a terminal: until Ctrl-C or the end of the viewer. Elsewhere nobody could end it, so it ends with the run.
void wait_for_viewer(const RunOutcome& outcome);

}  // namespace hrp
