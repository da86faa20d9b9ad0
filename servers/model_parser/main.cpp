// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "common/node/runner.h"
#include "servers/model_parser/node.h"

int main(int argc, char** argv) {
  std::string scenario;
  bool verbose = false;
  return hrp::run_server(
      argc, argv, {"model_parser", "hrp-model-parser", "Reads a scenario and its URDF and publishes the robot."},
      [&](const hrp::NodeContext& context) {
        return std::make_unique<hrp::ModelParserNode>(context, scenario, verbose);
      },
      [&](CLI::App& app) {
        app.add_option("SCENARIO", scenario, "scenario file (YAML)")->required();
        app.add_flag("--verbose", verbose, "every warning in full");
      });
}
