// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <optional>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/version.h"
#include "common/messages/convert.h"
#include "common/node/join.h"
#include "common/node/runner.h"
#include "servers/console/run_control/run_control.h"

namespace {

// Adds one subcommand that sends `request`.
CLI::App* add_request(CLI::App& app, const std::string& name, const std::string& text, hrp::msg::RunRequest request,
                      hrp::msg::RunControl* control) {
  CLI::App* command = app.add_subcommand(name, text);
  command->fallthrough();  // --domain and --secure may stand behind it, too
  command->callback([control, request] { control->request(request); });
  return command;
}

struct PushWords {
  std::vector<double> force, point{0.0, 0.0, 0.0};
};

CLI::App* add_push(CLI::App& app, PushWords* words, hrp::msg::RunControl* control) {
  CLI::App* command = add_request(
      app, "push",
      "push a link or an object: a constant force in world axes, from the next step that is not granted yet",
      hrp::msg::REQUEST_PUSH, control);
  command
      ->add_option("LINK", control->push().link(),
                   "link of the robot, object of the scenario, or ROBOT/LINK of another robot")
      ->required();
  command->add_option("--force", words->force, "X Y Z [N], world axes; 0 0 0 lets go")->required()->expected(3);
  command->add_option("--at", words->point, "X Y Z [m], where the force acts, link axes; default: the link's origin")
      ->expected(3);
  command
      ->add_option("--steps", control->push().steps(),
                   "how many steps it lasts; the next push of this link ends it earlier")
      ->check(CLI::Range(0, 1000000));
  return command;
}

hrp::msg::Vector3 make_vector(const std::vector<double>& v) { return hrp::to_message(hrp::Vector3d(v[0], v[1], v[2])); }

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Steers a running simulation: pause, run, single steps, reset, stop, status, list.", "hrp-run");
  app.set_version_flag("--version", hrp::get_version_text("hrp-run"));
  app.require_subcommand(1);
  hrp::JoinOptions join;
  hrp::add_join_options(app, &join);
  hrp::msg::RunControl control;
  std::optional<double> speed;
  unsigned long long steps = 1;
  bool follow = false;
  add_request(app, "pause", "pause the run after the steps that are granted already", hrp::msg::REQUEST_PAUSE,
              &control);
  add_request(app, "run", "resume the run", hrp::msg::REQUEST_RUN, &control)
      ->add_option("--speed", speed,
                   "at most this many simulated seconds per second; 0 = no limit; default: unchanged");
  add_request(app, "step", "make N steps and pause again", hrp::msg::REQUEST_STEP, &control)
      ->add_option("N", steps, "number of steps")
      ->check(CLI::Range(1, 1000000));
  add_request(app, "reset", "start the run again at step 0", hrp::msg::REQUEST_RESET, &control);
  add_request(app, "stop", "end the run and close the log", hrp::msg::REQUEST_STOP, &control);
  control.push().steps(100);
  PushWords push_words;
  CLI::App* push = add_push(app, &push_words, &control);
  CLI::App* status = app.add_subcommand("status", "print phase, step and time of the run");
  status->add_flag("--follow", follow, "print until the run ends");
  CLI::App* list = app.add_subcommand("list", "list the runs of this machine: scenario, process, domain, log");
  CLI::App* domain = app.add_subcommand("domain", "print the run's DDS domain, for programs of your own");
  for (CLI::App* command : {status, list, domain}) command->fallthrough();
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  control.speed(speed.value_or(0.0));
  control.change_speed(speed.has_value());
  control.steps(steps);
  if (push->parsed()) {
    control.push().force(make_vector(push_words.force));
    control.push().p_LQ(make_vector(push_words.point));
  }
  hrp::handle_stop_signals();
  try {
    if (list->parsed()) {
      std::printf("%s\n", hrp::describe_entries(hrp::find_runs()).c_str());
      return hrp::kExitOk;
    }
    const auto run = hrp::find_run_to_join(join, {"hrp-run", "", /*waits=*/false});
    if (!run) return hrp::kExitInterrupted;
    if (domain->parsed()) {
      std::printf("%d\n", run->entry.domain);
      return hrp::kExitOk;
    }
    join.only_looks = status->parsed();
    const auto bus = hrp::make_bus(hrp::make_join_bus_options(*run, join));
    return status->parsed() ? hrp::show_status(*bus, *run, follow) : hrp::send_request(*bus, *run, control);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-run: %s\n", error.what());
    return hrp::kExitFailed;
  }
}
