// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "common/node/runner.h"
#include "servers/logger/node.h"

int main(int argc, char** argv) {
  hrp::LoggerOptions options;
  options.gathered = true;
  return hrp::run_server(
      argc, argv, {"logger", "hrp-logger", "Writes every step of a run to an MCAP file."},
      [&](const hrp::NodeContext& context) { return std::make_unique<hrp::LoggerNode>(context, options); },
      [&](CLI::App& app) {
        app.add_option("--log", options.path,
                       "file to write; after a reset, the next file gets a number before its extension")
            ->capture_default_str();
        app.add_option("--compression", options.compression, "compression of the log; default: the scenario's")
            ->check(CLI::IsMember({"none", "lz4", "zstd"}));
        app.add_option("--robots", options.robots,
                       "names of the scenario's other robots, whose sensor data and commands are logged, too")
            ->delimiter(',');
        app.add_flag("--force", options.force, "overwrite an existing log");
        app.add_flag("--durable", options.durable,
                     "flush each part of the log to the disk: a power cut loses no step that counts as logged");
      });
}
