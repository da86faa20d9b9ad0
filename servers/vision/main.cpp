// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/runner.h"
#include "servers/vision/node.h"

int main(int argc, char** argv) {
  return hrp::run_server(argc, argv,
                         {"vision", "hrp-vision",
                          "Takes the pictures and scans of the scenario's cameras and lidars, and publishes them."},
                         [](const hrp::NodeContext& context) { return std::make_unique<hrp::VisionNode>(context); });
}
