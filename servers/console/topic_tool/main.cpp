// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/number_option.h"
#include "common/base/version.h"
#include "common/base/write_file.h"
#include "common/node/join.h"
#include "common/node/runner.h"
#include "servers/console/topic_tool/topic_tool.h"

namespace {

// Joins the run and does what is asked for there.
int look(const hrp::JoinOptions& join, const std::function<int(const hrp::ToolContext&)>& work) {
  hrp::handle_stop_signals();
  const auto run = hrp::find_run_to_join(join, {"hrp-topic", "", /*waits=*/false});
  if (!run) return hrp::kExitInterrupted;
  const auto opened = hrp::make_bus(hrp::make_join_bus_options(*run, join));
  hrp::RunWatch watch(*run);
  hrp::WaitVoice voice("hrp-topic", *run);
  return work({opened.get(), [&] { return hrp::g_stop_signal || watch.has_gone(); },
               [&](const std::string& what) { voice.update(what, hrp::WaitVoice::Clock::now()); }});
}

int run(int argc, char** argv) {
  CLI::App app(
      "Shows the topics of a run, and sends it commands. It reads best-effort, so it never slows or changes the run.",
      "hrp-topic");
  app.set_version_flag("--version", hrp::get_version_text("hrp-topic"));
  app.footer(
      "Examples:\n"
      "  hrp-topic list\n"
      "  hrp-topic echo contact_forces --rate 2                the same as hrp/contact_forces\n"
      "  hrp-topic echo hrp/contact_forces --field 'pairs[0].total.force.z' --field header.time\n"
      "  hrp-topic echo hrp/robot_state --json --count 100 > states.jsonl\n"
      "  hrp-topic hz hrp/robot_state\n"
      "  hrp-topic type ContactForces\n"
      "  hrp-topic pub joint_trajectory '{joint_names: [R_ELBOW], points: [{positions: [-1.2], time_from_start: {sec: "
      "2}}]}'");
  app.require_subcommand(1);
  hrp::JoinOptions join;
  hrp::add_join_options(app, &join);
  double seconds = 1.0;
  long lines = 0;
  std::string name;
  hrp::EchoOptions echo;
  CLI::App* list = app.add_subcommand("list", "topics with types, writers, readers and measured rates");
  list->add_option("--seconds", seconds, "[s] time for measuring the rates")
      ->check(hrp::refuse_nan)
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  list->add_flag("--json", echo.json, "one JSON object per line");
  CLI::App* show = app.add_subcommand("echo", "print the samples of a topic, until Ctrl-C or the end of the run");
  show->add_option("TOPIC", echo.topic, "name as in the list, or its last part")->required();
  show->add_flag("--json", echo.json, "one JSON object per line, with exact numbers");
  show->add_option("--count", echo.count, "stop after this number of samples")->check(CLI::PositiveNumber);
  show->add_option("--field", echo.fields, "print only this part, such as pairs[0].total.force.z; may be repeated");
  show->add_option("--rate", echo.rate, "at most this many samples per second")
      ->check(hrp::refuse_nan)
      ->check(CLI::Range(1e-3, 1e6));
  CLI::App* hz = app.add_subcommand("hz", "print rate, size and longest gap of a topic every second");
  hz->add_option("TOPIC", name, "name as in the list, or its last part")->required();
  hz->add_option("--count", lines, "stop after this number of lines")->check(CLI::PositiveNumber);
  CLI::App* type = app.add_subcommand("type", "print the IDL of a type, or of a topic's type, with units");
  type->add_option("NAME", name, "topic or type, such as hrp/robot_state, RobotState or hrp::msg::RobotState")
      ->required();
  std::string text;
  bool only_print = false;
  CLI::App* pub = app.add_subcommand("pub", "send one message to hrp-controller-ros, as ros2 topic pub --once does");
  pub->add_option("TOPIC", name,
                  "joint_trajectory or position_commands; of another robot, such as partner/joint_trajectory")
      ->required();
  pub->add_option("MESSAGE", text, "fields and values in YAML or JSON; other fields are zero or empty")->required();
  pub->add_flag("--print", only_print, "print the message as JSON and send nothing");
  for (CLI::App* command : {list, show, hz, type, pub}) command->fallthrough();
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  try {
    if (type->parsed()) return hrp::print_type(name);
    hrp::CommandSample command;
    if (pub->parsed()) command = hrp::make_command_sample(name, text);
    if (only_print) return hrp::print_command(command);
    join.only_looks = !pub->parsed();
    return look(join, [&](const hrp::ToolContext& context) {
      if (list->parsed()) return hrp::list_topics(context, seconds, echo.json);
      if (hz->parsed()) return hrp::measure_topic(context, name, lines);
      return pub->parsed() ? hrp::publish_command(context, command) : hrp::echo_topic(context, echo);
    });
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-topic: %s\n", error.what());
    return 2;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int status = run(argc, argv);
  return hrp::finish_output("hrp-topic") ? status : std::max(status, 1);
}
