// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/runner.h"
#include "servers/dynamics/engine.h"

int main(int argc, char** argv) {
  return hrp::run_server(argc, argv, {"dynamics", "hrp-dynamics", "Integrates the robot, one step at a time."},
                         [](const hrp::NodeContext& context) {
                           return std::make_unique<hrp::DynamicsLoop>(context, hrp::make_simulator_engine);
                         });
}
