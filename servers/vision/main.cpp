// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/runner.h"
#include "servers/vision/node.h"

int main(int argc, char** argv) {
  return hrp::run_server(argc, argv, {"vision", "hrp-vision", "Shows what cameras and lidars see."},
                         [](const hrp::NodeContext& context) { return std::make_unique<hrp::VisionNode>(context); });
}
