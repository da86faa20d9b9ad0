// SPDX-License-Identifier: BSD-3-Clause
#include "controller/client.h"

#include "common/node/runner.h"
#include "controller/node.h"

namespace hrp {

int run_controller(int argc, char** argv, const std::string& program, const ControllerMaker& make_controller) {
  return run_server(
      argc, argv, {"controller", program, "A controller: answers every sample of sensor data with joint commands."},
      [&](const NodeContext& context) { return std::make_unique<ControllerNode>(context, make_controller); });
}

}  // namespace hrp
