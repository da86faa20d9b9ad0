// SPDX-License-Identifier: BSD-3-Clause
#include <sched.h>

#include <chrono>
#include <cstdio>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/diagnostics.h"
#include "common/base/printable.h"
#include "common/base/version.h"
#include "common/node/far_launcher.h"
#include "common/node/join.h"
#include "common/node/run_token.h"
#include "common/node/runner.h"

namespace hrp {
namespace {

// A run whose launcher has gone says its end to everybody within this time, or never.
constexpr auto kLastWords = std::chrono::seconds(2);

struct CommonOptions {
  JoinOptions join;
  BusOptions bus;
  std::string role;
  std::string robot;
  long parent = 0;
  bool far_launcher = false;
};

void add_common_options(CLI::App& app, const std::string& role, CommonOptions* options) {
  add_join_options(app, &options->join);
  app.add_option(
      "--network-interface", options->bus.network_interface,
      "IPv4 address of the interface to use; default: loopback only. ADDRESS,PEER,... looks for other programs at\n"
      "these peers instead of by multicast");
  app.add_option("--dds-config", options->bus.config_file,
                 "file in the DDS vendor's own format that replaces all network settings");
  app.add_option("--role", options->role, "name under which this server reports; default: " + role);
  if (role == "controller")
    app.add_option("--robot", options->robot,
                   "name of the robot to control, where the scenario has other 'robots'; default: its first one");
  app.add_option("--parent", options->parent, "process id: end when this parent ends (used by hrp-simulate)");
  app.add_flag(
      "--far-launcher", options->far_launcher,
      "the launcher is on another machine and talks to this server through standard input (used by hrp-simulate --on)");
}

// Ends a node whose run has gone without a word: its launcher was killed.
class GoneRun {
 public:
  GoneRun(const JoinedRun& run, const std::string& program) : watch_(run), program_(program) {}
  void update(WaitVoice::Clock::time_point now) {
    if (!watch_.has_gone() || said_) return;
    if (since_ == WaitVoice::Clock::time_point{}) since_ = now;
    if (now - since_ < kLastWords) return;
    said_ = true;
    std::fprintf(stderr, "%s: the run has gone, its launcher with it; ends\n", program_.c_str());
    g_stop_signal = true;
  }

  bool was_said() const { return said_; }

 private:
  RunWatch watch_;
  std::string program_;
  WaitVoice::Clock::time_point since_{};
  bool said_ = false;
};

// A scheduler that was started by hand makes a run of the domain that it was given, so that others find it.
DomainClaim claim_by_hand(const JoinedRun& run, const ServerProgram& program, bool secured) {
  if (run.registered || program.role != "scheduler") return {};
  DomainClaim claim = claim_domain(run.entry.domain, "servers started by hand");
  RunEntry entry = claim.entry();
  entry.vendor = run.entry.vendor;
  entry.token = make_run_token();
  entry.secured = secured;
  entry.free_places = {"model_parser", "logger", "dynamics", "collision_checker", "controller", "vision"};
  claim.describe(entry);
  return claim;
}

// A server hands its step to the next one, and then waits. On few cores, one that is woken must not push one that runs
// off its core: the logger would do so at every sample. Whoever has chosen another policy keeps it. Threads that come
// later inherit it.
void let_others_finish() {
  if (sched_getscheduler(0) != SCHED_OTHER) return;
  const sched_param none{};
  sched_setscheduler(0, SCHED_BATCH, &none);  // where this is refused, the run is as right, and slower
}

int run(const ServerProgram& program, const CommonOptions& options, const NodeMaker& make_node) {
  let_others_finish();
  handle_stop_signals();
  if (!end_with_parent(options.parent)) return kExitFailed;
  const std::string place = options.robot.empty() ? program.role : make_controller_role(options.robot);
  auto joined = options.far_launcher ? join_far_run(options.join)
                                     : find_run_to_join(options.join, {program.program, place, /*waits=*/true});
  if (!joined) return kExitInterrupted;
  const DomainClaim claim = claim_by_hand(*joined, program, !options.join.secure.empty());
  const std::unique_ptr<Bus> bus = make_bus(make_join_bus_options(*joined, options.join, options.bus));
  const bool has_token = options.far_launcher || joined->registered;
  const std::unique_ptr<Node> node = make_node({bus.get(), options.role.empty() ? place : options.role, program.program,
                                                has_token ? joined->entry.token : claim.entry().token, options.robot});
  // The launcher speaks for its own children, and the system ends them with it.
  if (options.far_launcher) end_with_far_launcher(program.program);
  if (options.far_launcher || joined->is_launched_by_it()) return run_process(*node, *bus, program.program);
  WaitVoice voice(program.program, *joined);
  GoneRun gone(*joined, program.program);
  const int exit_code = run_process(*node, *bus, program.program, [&](const std::string& waits_for) {
    const auto now = WaitVoice::Clock::now();
    voice.update(waits_for, now);
    gone.update(now);
  });
  return gone.was_said() && exit_code == kExitOk ? kExitFailed : exit_code;
}

}  // namespace

int run_server(int argc, char** argv, const ServerProgram& program, const NodeMaker& make_node,
               const OptionAdder& add_options) {
  CLI::App app(program.description, program.program);
  app.set_version_flag("--version", get_version_text(program.program));
  CommonOptions options;
  add_common_options(app, program.role, &options);
  if (add_options) add_options(app);
  if (const auto status = take_command_line(&app, argc, argv)) return *status;
  try {
    return run(program, options, make_node);
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kExitBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program.program.c_str(), make_printable(error.what()).c_str());
    return kExitFailed;
  }
}

}  // namespace hrp
