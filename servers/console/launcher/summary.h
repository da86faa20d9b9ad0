// SPDX-License-Identifier: BSD-3-Clause
// The words at the end of a run.
#pragma once

#include <string>

#include "servers/console/launcher/run_set.h"

namespace hrp {

// Whether the set has a logger.
bool is_logged(const LaunchOptions& options);

// The file that the command line names; it must be new, or empty, unless --force is given. Without one the file that
// the scenario names, else "logs/SCENARIO-YYYYMMDD-HHMMSS.mcap" under the working folder; "-2", "-3", ... is added to
// these when they are taken. Makes the folder. Throws InputError when that fails.
std::string choose_log_file(const LaunchOptions& options, const Scenario& scenario);

// The name of a log. An empty file that kept the name is removed at the end.
class LogName {
 public:
  explicit LogName(const std::string& path) : path_(path) {}
  ~LogName();
  LogName(const LogName&) = delete;
  LogName& operator=(const LogName&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

// Says how long the run was and, of each log that this run wrote, up to which step it is complete and the last state's
// hash. Reads nothing of older files.
void print_summary(const LaunchOptions& options, const RunOutcome& outcome, const std::string& log);

}  // namespace hrp
