// SPDX-License-Identifier: BSD-3-Clause
// Command line of hrp-simulate.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "servers/console/launcher/hosts.h"

namespace hrp {

struct LaunchOptions {
  std::string scenario;
  std::string dds = "cyclone";
  std::map<std::string, std::string> dds_for;   // role -> vendor
  std::map<std::string, std::string> programs;  // role -> program in place of ours
  std::vector<std::string> controller;          // words of a command in place of our controller; empty: none
  std::vector<std::string> without;             // roles that somebody else starts
  std::map<std::string, Host> on;               // role -> machine, of those that are not on this one
  std::vector<std::string> ssh;                 // words of the command that reaches a machine
  double duration = -1.0;   // [s] simulated; < 0: as the scenario says
  bool in_process = false;
  double speed = 0.0;       // [s/s] 0 = as fast as it goes
  double ros_rate = 0.0;    // [1/s simulated] of joint states and frames for ROS 2; 0 = every control period
  bool ros_services = false;  // pause, resume, step and reset for ROS 2
  std::string log;          // empty: chosen
  bool force = false;       // overwrite it
  bool durable = false;     // each part of it is brought to the disk
  int domain = -1;          // < 0: a free one
  std::string secure;       // folder of the identity of all servers; empty: not secured
  bool paused = false;
  bool keep_going = false;
  bool pin = true;
  bool quiet = false;
  bool verbose = false;
  bool plot = true;
  bool view = false;        // with the viewer, not faster than real time unless a speed is given
  int view_port = 0;        // 0: a free one
};

// Returns true when the run may start; else `exit_code` is what the program ends with (help, wrong option).
[[nodiscard]] bool parse_launch_options(int argc, char** argv, LaunchOptions* options, int* exit_code);

// Roles of a set, in the order they are started.
const std::vector<std::string>& get_roles();

}  // namespace hrp
