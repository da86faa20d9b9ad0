// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/runner.h"
#include "servers/mujoco_dynamics/engine.h"

int main(int argc, char** argv) {
  return hrp::run_server(
      argc, argv, {"dynamics", "hrp-dynamics-mujoco", "Integrates the robot with MuJoCo, in place of hrp-dynamics."},
      [](const hrp::NodeContext& context) {
        return std::make_unique<hrp::DynamicsLoop>(context, hrp::make_mujoco_engine);
      });
}
