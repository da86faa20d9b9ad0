// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/dynamics_main.h"

#include <CLI/CLI.hpp>

namespace hrp {

int run_dynamics_server(int argc, char** argv, const ServerProgram& program, const EngineFactory& make_engine) {
  double ros_rate = 0.0;
  return run_server(
      argc, argv, program,
      [&](const NodeContext& context) { return std::make_unique<DynamicsLoop>(context, make_engine, ros_rate); },
      [&](CLI::App& app) {
        app.add_option("--ros-rate", ros_rate,
                       "[Hz of simulated time] rate of /joint_states and /tf for ROS 2; 0 = every control period")
            ->check([](const std::string& word) { return find_ros_rate_fault(std::strtod(word.c_str(), nullptr)); });
      });
}

}  // namespace hrp
