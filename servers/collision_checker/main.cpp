// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/runner.h"
#include "servers/collision_checker/node.h"

int main(int argc, char** argv) {
  return hrp::run_server(
      argc, argv,
      {"collision_checker", "hrp-collision-checker",
       "Collision checker: finds the contacts of links, ground, obstacles and objects at every step."},
      [](const hrp::NodeContext& context) { return std::make_unique<hrp::CollisionCheckerNode>(context); });
}
