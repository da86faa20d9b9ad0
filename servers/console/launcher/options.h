// SPDX-License-Identifier: BSD-3-Clause
// Command line of hrp-simulate.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/robot/scenario.h"
#include "servers/console/launcher/hosts.h"

namespace hrp {

struct LaunchOptions {
  std::string scenario;
  std::string dds = "cyclone";
  std::map<std::string, std::string> dds_for;                // role -> vendor
  std::map<std::string, std::string> programs;               // role -> program in place of ours
  std::map<std::string, std::vector<std::string>> commands;  // role of a controller -> words of a command in its place
  std::vector<std::string> without;                          // roles that somebody else starts
  std::map<std::string, Host> on;                            // role -> machine, of those that are not on this one
  std::vector<std::string> ssh;                              // words of the command that reaches a machine
  double duration = -1.0;                                    // [s] simulated; < 0: as the scenario says
  bool in_process = false;
  double speed = 0.0;         // [s/s] 0 = as fast as it goes
  double ros_rate = 0.0;      // [1/s simulated] of joint states and frames for ROS 2; 0 = every control period
  bool ros_services = false;  // pause, resume, step and reset for ROS 2
  std::string log;            // empty: chosen
  bool force = false;         // overwrite it
  bool durable = false;       // each part of it is brought to the disk
  int domain = -1;            // < 0: a free one
  std::string secure;         // folder of the identity of all servers; empty: not secured
  bool paused = false;
  bool keep_going = false;
  bool pin = true;
  bool quiet = false;
  bool verbose = false;
  bool plot = true;
  bool view = false;  // with the viewer, not faster than real time unless a speed is given
  int view_port = 0;  // 0: a free one
};

// Returns true when the run may start; else `exit_code` is what the program ends with (help, wrong option).
[[nodiscard]] bool parse_launch_options(int argc, char** argv, LaunchOptions* options, int* exit_code);

// Roles of a set, in the order they are started; controllers of other robots come after that of the first one.
std::vector<std::string> list_roles(const Scenario& scenario);

// Adds to `without` the controllers of robots whose scenarios say `controller: {type: none}`.
void leave_out_absent_controllers(const Scenario& scenario, LaunchOptions* options);

// Throws InputError: an option names the controller of a robot that the scenario has not.
void check_robots(const LaunchOptions& options, const Scenario& scenario);

}  // namespace hrp
