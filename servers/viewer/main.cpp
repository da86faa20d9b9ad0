// SPDX-License-Identifier: BSD-3-Clause
#include <sys/resource.h>

#include <cstdio>
#include <filesystem>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/shared_files.h"
#include "common/base/version.h"
#include "common/node/join.h"
#include "common/node/runner.h"
#include "servers/viewer/viewer.h"
#include "servers/viewer/web_server.h"

namespace {

namespace fs = std::filesystem;

constexpr int kTickMs = 33;  // 30 pictures a second

struct Options {
  std::vector<std::string> files;
  hrp::JoinOptions join;
  hrp::WebOptions web;
  hrp::ViewerOptions viewer;
  bool read_only = false;
};

void add_options(CLI::App& app, Options* options) {
  app.footer(
      "Without files, it joins the live run. Examples:\n"
      "  hrp-viewer                            a live run\n"
      "  hrp-viewer run.mcap                   a recorded one\n"
      "  hrp-viewer run.mcap other.mcap        two, the second as a ghost\n"
      "  hrp-viewer experiment/                CSV recordings of an experiment folder\n"
      "Foxglove connects to the same address with ws in the place of http, token included.");
  app.add_option("FILES", options->files, "logs (MCAP), or experiment folders");
  hrp::add_join_options(app, &options->join);
  app.add_option("--port", options->web.port, "port of the page; 0 = a free port")->capture_default_str();
  app.add_option("--address", options->web.address, "address to listen on; default: this machine only")
      ->capture_default_str();
  app.add_option("--token", options->web.access.token, "token that a browser must send; default: a random one");
  app.add_flag("--read-only", options->read_only, "pages cannot steer the run");
  app.add_option("--page", options->viewer.page_folder,
                 "folder of the page; default: ../share/viewer beside this program");
  app.add_option("--then", options->viewer.log_after, "log of the live run, shown after the run has ended");
}

void show_files(const std::vector<std::string>& files, hrp::Viewer* viewer) {
  std::vector<std::unique_ptr<hrp::Recording>> recordings;
  for (const std::string& file : files) {
    if (fs::path(file).extension() == ".mcap") {
      recordings.push_back(hrp::read_log(file));
    } else {
      for (auto& each : hrp::read_experiment(file)) recordings.push_back(std::move(each));
    }
  }
  viewer->show(std::move(recordings));
}

int serve(Options options) {
  std::unique_ptr<hrp::Bus> bus;  // outlives its readers
  if (options.viewer.page_folder.empty()) options.viewer.page_folder = hrp::find_shared_file("viewer");
  hrp::Viewer viewer(options.viewer);
  if (options.files.empty()) {
    const auto run = hrp::find_run_to_join(options.join, {"hrp-viewer", "", /*waits=*/false});
    if (!run) return hrp::kExitInterrupted;
    options.join.only_looks = options.read_only;
    bus = hrp::make_bus(hrp::make_join_bus_options(*run, options.join));
    viewer.show(std::make_unique<hrp::LiveRun>(*bus, options.read_only, *run));
  } else {
    show_files(options.files, &viewer);
  }
  hrp::AccessRules& access = options.web.access;
  access.loopback = hrp::is_loopback_address(options.web.address);
  // On this machine, too: every user of it reaches its ports.
  if (access.token.empty()) access.token = hrp::make_token();
  hrp::WebServer server(options.web, viewer);
  const std::string host =
      options.web.address.find(':') == std::string::npos ? options.web.address : "[" + options.web.address + "]";
  std::printf("viewer     http://%s:%u/%s%s\n", host.c_str(), server.port(), "?token=", access.token.c_str());
  std::fflush(stdout);
  server.run(kTickMs, [&] {
    viewer.tick();
    return !hrp::g_stop_signal;
  });
  return hrp::kExitOk;
}

}  // namespace

int main(int argc, char** argv) {
  // First of all: who starts a viewer and changes his mind at once gets a clean end, too.
  hrp::handle_stop_signals();
  CLI::App app("Shows a run, its contact forces and charts in the browser. It never slows or changes the run.",
               "hrp-viewer");
  app.set_version_flag("--version", hrp::get_version_text("hrp-viewer"));
  Options options;
  add_options(app, &options);
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  // The run comes first where cores are few.
  setpriority(PRIO_PROCESS, 0, 10);
  try {
    return serve(std::move(options));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-viewer: %s\n", error.what());
    return hrp::kExitBadInput;
  }
}
