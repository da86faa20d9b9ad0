// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "common/node/runner.h"
#include "servers/scheduler/node.h"

int main(int argc, char** argv) {
  hrp::SchedulerOptions options;
  options.roles = {"dynamics"};
  double duration = -1.0;
  bool ros_services = false;
  return hrp::run_server(
      argc, argv, {"scheduler", "hrp-scheduler", "Grants the steps of a run: run, pause, single step, reset."},
      [&](const hrp::NodeContext& context) {
        return std::make_unique<hrp::SchedulerNode>(context, options, duration, ros_services);
      },
      [&](CLI::App& app) {
        app.add_option("--wait-for", options.roles, "roles that must be ready before the first step")
            ->delimiter(',')
            ->capture_default_str();
        app.add_option("--duration", duration, "[s] of simulated time; 0 = until stopped; default: the scenario's")
            ->check(
                [](const std::string& word) { return hrp::find_duration_fault(std::strtod(word.c_str(), nullptr)); });
        app.add_option("--speed", options.speed, "at most this many simulated seconds per second; 0 = no limit")
            ->check([](const std::string& word) { return hrp::find_speed_fault(std::strtod(word.c_str(), nullptr)); })
            ->capture_default_str();
        app.add_option("--window", options.window, "[steps] number of steps that one grant allows")
            ->check(CLI::Range(1, 100))
            ->capture_default_str();
        app.add_flag("--ros-services", ros_services,
                     "offers the ROS 2 services /run/pause, /run/resume, /run/step, /run/reset to anybody who reaches "
                     "the domain");
        app.add_flag("--paused", options.paused, "wait for hrp-run before the first step");
      });
}
