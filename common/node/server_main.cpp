// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include <CLI/CLI.hpp>

#include "common/base/diagnostics.h"
#include "common/bus/make_bus.h"
#include "common/node/runner.h"

namespace hrp {
namespace {

struct CommonOptions {
  BusOptions bus;
  std::string role;
  long parent = 0;
};

void add_common_options(CLI::App& app, CommonOptions* options) {
  app.add_option("--domain", options->bus.domain, "DDS domain of the run")->capture_default_str();
  app.add_option("--dds", options->bus.vendor, "DDS implementation")
      ->check(CLI::IsMember(find_bus_vendors()))
      ->capture_default_str();
  app.add_option("--network-interface", options->bus.network_interface,
                 "IPv4 address of the interface to use; without it nothing leaves the machine");
  app.add_option("--dds-config", options->bus.config_file,
                 "file in the DDS vendor's own format that replaces all network settings");
  app.add_option("--role", options->role, "name under which this server reports")->capture_default_str();
  app.add_option("--parent", options->parent, "process id: end when this parent ends (used by hrp-simulate)");
}

int run(const ServerProgram& program, const CommonOptions& options, const NodeMaker& make_node) {
  handle_stop_signals();
  if (!end_with_parent(options.parent)) return kExitFailed;
  const std::unique_ptr<Bus> bus = make_bus(options.bus);
  const std::unique_ptr<Node> node = make_node({bus.get(), options.role, program.program});
  return run_process(*node, *bus, program.program);
}

}  // namespace

int run_server(int argc, char** argv, const ServerProgram& program, const NodeMaker& make_node,
               const OptionAdder& add_options) {
  CLI::App app(program.description, program.program);
  CommonOptions options;
  options.role = program.role;
  add_common_options(app, &options);
  if (add_options) add_options(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitBadInput;
  }
  try {
    return run(program, options, make_node);
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kExitBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.program.c_str(), error.what());
    return kExitFailed;
  }
}

}  // namespace hrp
