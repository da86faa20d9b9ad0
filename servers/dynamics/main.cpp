// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/dynamics_main.h"
#include "servers/dynamics/engine.h"

int main(int argc, char** argv) {
  return hrp::run_dynamics_server(argc, argv, {"dynamics", "hrp-dynamics", "Integrates the robot, one step at a time."},
                                  hrp::make_simulator_engine);
}
