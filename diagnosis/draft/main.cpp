// SPDX-License-Identifier: BSD-3-Clause
// hrp-draft-experiment ROBOT LOG... --out EXPERIMENT.yaml: a first experiment file for logs as people have them.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/command_line.h"
#include "common/base/diagnostics.h"
#include "common/base/run_main.h"
#include "common/base/version.h"
#include "common/base/write_file.h"
#include "diagnosis/draft/draft.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kHelp =
    "Writes a first experiment.yaml for a robot and its logs. It guesses from names and numbers which column of a text "
    "log\n"
    "holds which signal, and asks for the rest.\n"
    "Example: hrp-draft-experiment arm.urdf log_1.csv log_2.csv --out experiment.yaml\n"
    "Exit status: 0 the draft is written, 2 bad input, 1 it could not be written.";

struct Options {
  std::string robot, out = "experiment.yaml";
  std::vector<std::string> logs;
  bool force = false;
};

int run(const Options& o) {
  if (!o.force && std::filesystem::exists(o.out))
    refuse_input(o.out, "is there already: give another --out, or --force");
  const Draft draft = make_draft(o.robot, o.logs, std::filesystem::path(o.out).parent_path().string());
  write_file(o.out, draft.text);
  for (const std::string& line : draft.found) std::printf("found  %s\n", line.c_str());
  for (const std::string& line : draft.asked) std::printf("(?)    %s\n", line.c_str());
  std::printf("\n%s is a draft. Look at each line; then: scripts/diagnose.sh %s --check\n", o.out.c_str(),
              o.out.c_str());
  return finish_output("hrp-draft-experiment") ? 0 : 1;
}

}  // namespace
}  // namespace hrp::diagnosis

int main(int argc, char** argv) {
  CLI::App app{hrp::diagnosis::kHelp};
  app.set_version_flag("--version", hrp::get_version_text("hrp-draft-experiment"));
  hrp::diagnosis::Options options;
  app.add_option("robot", options.robot, "the robot's model: URDF, MJCF or SDF")->required();
  app.add_option("logs", options.logs,
                 "logs: text files, MCAP logs, bags of ROS 1 or 2; with several, the last one is held out")
      ->required();
  app.add_option("--out", options.out, "experiment file to write")->capture_default_str();
  app.add_flag("--force", options.force, "overwrite OUT");
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  return hrp::run_main("hrp-draft-experiment", [&] { return hrp::diagnosis::run(options); });
}
