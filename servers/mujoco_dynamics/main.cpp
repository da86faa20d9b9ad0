// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/dynamics_main.h"
#include "servers/mujoco_dynamics/engine.h"

int main(int argc, char** argv) {
  return hrp::run_dynamics_server(
      argc, argv, {"dynamics", "hrp-dynamics-mujoco", "Integrates the robot with MuJoCo, in place of hrp-dynamics."},
      hrp::make_mujoco_engine);
}
