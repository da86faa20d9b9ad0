// SPDX-License-Identifier: BSD-3-Clause
// Command lines of a run's servers: of children on this machine, of servers on others, of the viewer, and of a server
// that somebody starts by hand.
#pragma once

#include <string>
#include <vector>

#include "common/bus/run_entry.h"
#include "common/robot/scenario.h"
#include "servers/console/launcher/child_process.h"
#include "servers/console/launcher/options.h"
#include "servers/console/launcher/remote_server.h"

namespace hrp {

// The path of a program: with a slash as it is; else ours, beside this one; else the one that a shell would run.
std::string find_command(const std::string& name);

// Keeps references to `options` and `scenario`. `entry` describes the run: domain, network, token.
class ServerCommands {
 public:
  ServerCommands(const LaunchOptions& options, const Scenario& scenario, const std::string& log)
      : options_(options), scenario_(scenario), log_(log) {}

  bool is_left_out(const std::string& role) const;
  // Nobody looks where there are no cameras and no lidars.
  bool is_needed(const std::string& role) const { return role != "vision" || scenario_.sensors.has_vision(); }
  ChildSpec make_child(const std::string& role, const RunEntry& entry) const;
  RemoteCommand make_remote(const std::string& role, const RunEntry& entry) const;
  ChildSpec make_viewer(const RunEntry& entry) const;
  // A command line that takes a free place, whatever else runs on this machine.
  std::string make_join_command(const std::string& role) const;

 private:
  std::string get_program(const std::string& role) const;
  std::string get_vendor(const std::string& role) const;
  std::vector<std::string> make_role_arguments(const std::string& role) const;
  std::vector<std::string> find_files_of(const std::string& role) const;
  std::vector<std::string> find_motion(const std::string& robot) const;
  std::vector<int> find_cores_of(const std::string& role, int domain) const;

  const LaunchOptions& options_;
  const Scenario& scenario_;
  std::string log_;
};

}  // namespace hrp
