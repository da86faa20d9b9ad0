// SPDX-License-Identifier: BSD-3-Clause
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "common/base/has.h"
#include "common/bus/domain.h"
#include "common/bus/make_bus.h"
#include "common/messages/topics.h"
#include "common/node/node.h"
#include "common/node/run_token.h"
#include "common/node/runner.h"
#include "common/robot/movers.h"
#include "servers/console/launcher/child_process.h"
#include "servers/console/launcher/monitor.h"
#include "servers/console/launcher/remote_server.h"
#include "servers/console/launcher/run_set.h"
#include "servers/console/launcher/server_commands.h"
#include "servers/model_parser/robot_loader.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;

// The reason of a stop is with the scheduler. It ends everybody within this time (after the steps that it granted, or
// two seconds), else signals do.
constexpr auto kOrderlyEnd = std::chrono::seconds(3);
// What the others said last reaches the scheduler, and its answer this process, within this time.
constexpr auto kLastWords = std::chrono::milliseconds(100);
// A logger that closes a large file may need longer than the others.
constexpr auto kTermPatience = std::chrono::seconds(8);
// A server that ends with an exit status has said why on the bus, and that may still be on its way.
constexpr auto kReasonPatience = std::chrono::milliseconds(400);
// A server that ends well after the last step has been told so; the same word reaches this process, later on a busy
// machine with encryption than any reason does.
constexpr auto kFinishPatience = std::chrono::seconds(10);
// A server on another machine that everybody waits for so long has lost its way here.
constexpr auto kLinkPatience = std::chrono::seconds(10);
// Whom a run waits for is told after this time.
constexpr auto kWaitPatience = std::chrono::milliseconds(1000);

class ProcessRun {
 public:
  ProcessRun(const LaunchOptions& options, const Scenario& scenario, const std::string& log)
      : options_(options),
        scenario_(scenario),
        log_(log),
        commands_(options, scenario, log),
        progress_(options.quiet) {}

  RunOutcome run();

 private:
  void start_server(const std::string& role);
  void look_at_remotes();
  const RemoteServer* find_remote(const std::string& role) const;
  std::string describe_end_of(const ChildEnd& end) const;
  void note_wait(const std::string& late);
  void start_all();
  void say_what_is_missing();
  void say_who_can_listen() const;
  void watch();
  void handle_end(const ChildEnd& end);
  void say_viewer_ended(const ChildEnd& end);
  std::string find_refusal() const;
  void settle_pending();
  bool has_ended() const { return finished_ || monitor_->has_ended(); }
  bool ends_well(const ChildEnd& end) const;
  void fail(const std::string& failure);
  void show();
  void end_all();
  RunOutcome make_outcome();

  const LaunchOptions& options_;
  const Scenario& scenario_;
  std::string log_;
  ServerCommands commands_;
  DomainClaim claim_;
  Children children_;
  std::vector<std::unique_ptr<RemoteServer>> remotes_;
  std::shared_ptr<Children> viewer_;  // no part of the set: its end is not the run's
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<RunMonitor> monitor_;
  ProgressLine progress_;
  std::string failure_;
  bool finished_ = false;  // the scheduler's exit status said so, should its last message have been lost
  std::vector<std::pair<ChildEnd, Clock::time_point>> pending_;  // ended by themselves; the reason may still come
  bool bad_input_ = false;
  bool interrupted_ = false;
  bool first_step_seen_ = false;
  std::string waits_for_;  // role that is late
  Clock::time_point waits_since_;
  Clock::time_point start_;
};

const RemoteServer* ProcessRun::find_remote(const std::string& role) const {
  for (const auto& remote : remotes_) {
    if (remote->role() == role) return remote.get();
  }
  return nullptr;
}

void ProcessRun::look_at_remotes() {
  for (const auto& remote : remotes_) {
    for (const std::string& line : remote->update()) {
      progress_.clear();
      std::fprintf(stderr, "%s\n", line.c_str());
    }
    if (!remote->fault().empty()) fail(remote->fault());
  }
  const RemoteServer* late = first_step_seen_ ? find_remote(waits_for_) : nullptr;
  if (late && Clock::now() - waits_since_ > kLinkPatience) {
    fail(late->name() + " has been silent for 10 s at step " + std::to_string(monitor_->run_status().step()) +
         ": the way to that machine is broken, or the server hangs");
  }
}

std::string ProcessRun::describe_end_of(const ChildEnd& end) const {
  const std::string step = " at step " + std::to_string(monitor_->find_step_of_end(end.role));
  if (const RemoteServer* remote = find_remote(end.role)) return remote->describe_end(end.status) + step;
  return end.role + " (" + end.program + ", process " + std::to_string(end.process_id) + ") " +
         describe_end(end.status) + step;
}

void ProcessRun::start_server(const std::string& role) {
  if (options_.on.count(role) == 0) {
    children_.start(commands_.make_child(role, claim_.entry()));
    return;
  }
  remotes_.push_back(std::make_unique<RemoteServer>(commands_.make_remote(role, claim_.entry())));
  std::vector<std::string> ssh = options_.ssh;
  ssh[0] = find_command(ssh[0]);
  remotes_.back()->start(ssh, &children_);
}

void ProcessRun::start_all() {
  claim_ =
      options_.domain >= 0 ? claim_domain(options_.domain, options_.scenario) : claim_free_domain(options_.scenario);
  RunEntry entry = claim_.entry();
  entry.vendor = options_.dds;
  entry.network = options_.on.empty() ? "" : find_network(options_.on);
  entry.token = make_run_token();
  entry.log = commands_.is_left_out("logger") ? "" : log_;
  entry.free_places = options_.without;
  entry.secured = !options_.secure.empty();
  claim_.describe(entry);
  // Children first: this process has no threads yet.
  for (const std::string& role : list_roles(scenario_)) {
    if (commands_.is_left_out(role) || !commands_.is_needed(role)) continue;
    start_server(role);
  }
  if (options_.view) {
    viewer_ = std::make_shared<Children>();
    viewer_->start(commands_.make_viewer(claim_.entry()));
  }
  BusOptions bus;
  bus.secure = options_.secure;
  bus.vendor = options_.dds;
  bus.domain = claim_.domain();
  bus.network_interface = claim_.entry().network;
  bus_ = make_bus(bus);
  monitor_ = std::make_unique<RunMonitor>(*bus_, claim_.entry().token, list_robots(scenario_));
}

void ProcessRun::say_what_is_missing() {
  for (const std::string& role : options_.without) {
    std::printf("The place of %s is free, on DDS domain %d (%s). To join from another terminal:\n  %s\n", role.c_str(),
                claim_.domain(), options_.dds.c_str(), commands_.make_join_command(role).c_str());
    if (is_controller(role)) {
      std::printf(
          "  source: controller/template/my_controller.cpp; any program that reads %s and answers each\n"
          "  sample with %s of the same epoch and step will do (docs/client_in_c.md)\n",
          topics::of_robot(topics::kSensorData, find_robot_of(role)).name.c_str(),
          topics::of_robot(topics::kJointCommands, find_robot_of(role)).name.c_str());
    }
  }
  std::fflush(stdout);
}

void ProcessRun::say_who_can_listen() const {
  if (options_.on.empty() || !options_.secure.empty()) return;
  std::fprintf(stderr,
               "hrp-simulate: warning: this run leaves the machine without encryption; everybody on that network can "
               "read it and\n"
               "  disturb it. --secure DIR lets in only those with a certificate (docs/tutorials/secure.md)\n");
}

// Tells joiners whom everybody waits for, and people how to help when it is somebody of theirs.
void ProcessRun::note_wait(const std::string& late) {
  if (late != waits_for_) {
    waits_for_ = late;
    waits_since_ = Clock::now();
  }
  const bool waits = !late.empty() && Clock::now() - waits_since_ >= kWaitPatience;
  if (claim_.entry().waits_for == (waits ? late : "")) return;
  RunEntry entry = claim_.entry();
  entry.waits_for = waits ? late : "";
  claim_.describe(entry);
  if (!waits || !commands_.is_left_out(late) || !first_step_seen_) return;  // at the start it was said
  progress_.clear();
  std::printf("waits for %s; to join: %s\n", late.c_str(), commands_.make_join_command(late).c_str());
  std::fflush(stdout);
}

RunOutcome ProcessRun::run() {
  start_ = Clock::now();
  start_all();
  say_what_is_missing();
  say_who_can_listen();
  while (failure_.empty() && !interrupted_ && !has_ended()) watch();
  end_all();
  return make_outcome();
}

void ProcessRun::watch() {
  bus_->spin(std::chrono::milliseconds(10));
  if (g_stop_signal) interrupted_ = true;
  look_at_remotes();
  while (const auto end = children_.take_ended()) handle_end(*end);
  while (const auto end = viewer_ ? viewer_->take_ended() : std::nullopt) say_viewer_ended(*end);
  settle_pending();
  show();
}

void ProcessRun::handle_end(const ChildEnd& end) {
  if (options_.keep_going && end.role != "scheduler" && end.role != "logger" && WIFSIGNALED(end.status)) {
    progress_.clear();
    std::fprintf(stderr, "hrp-simulate: %s (%s, process %d) %s at step %llu; starting it again\n", end.role.c_str(),
                 end.program.c_str(), static_cast<int>(end.process_id), describe_end(end.status).c_str(),
                 static_cast<unsigned long long>(monitor_->find_step_of_end(end.role)));
    children_.start(*children_.find_spec(end.role));
    return;
  }
  if (WIFEXITED(end.status)) {
    if (WEXITSTATUS(end.status) == kExitBadInput) bad_input_ = true;
    // It may have gone before a reader that a busy machine discovered late had heard of the end.
    if (end.role == "scheduler" && WEXITSTATUS(end.status) == kExitOk) finished_ = true;
    pending_.emplace_back(end, Clock::now());
    return;
  }
  fail(describe_end_of(end));
}

// The run does not need it, but whoever looks at a page that stands still should know why.
void ProcessRun::say_viewer_ended(const ChildEnd& end) {
  progress_.clear();
  std::fprintf(stderr, "hrp-simulate: the viewer (%s, process %d) %s; the run goes on without it\n",
               end.program.c_str(), static_cast<int>(end.process_id), describe_end(end.status).c_str());
}

// On a busy machine the set may have refused its model and gone before this process was discovered.
std::string ProcessRun::find_refusal() const {
  try {
    load_robot(load_scenario(options_.scenario));
    return "";
  } catch (const InputError& error) {
    return std::string("model_parser: model refused\n") + error.what();
  }
}

// True for a server that ended with status 0 when the run had done its last step.
bool ProcessRun::ends_well(const ChildEnd& end) const {
  const double duration = options_.duration >= 0.0 ? options_.duration : scenario_.duration;
  const auto last_step = static_cast<uint64_t>(std::llround(duration / scenario_.time_step));
  return WEXITSTATUS(end.status) == 0 && monitor_->find_step_of_end("dynamics") >= last_step;
}

// A server that ends by itself while the run goes on, and nobody has said why.
void ProcessRun::settle_pending() {
  if (pending_.empty() || has_ended()) return;
  const auto& [end, since] = pending_.front();
  if (Clock::now() - since < (ends_well(end) ? Clock::duration(kFinishPatience) : Clock::duration(kReasonPatience)))
    return;
  const std::string refusal = find_refusal();
  if (!refusal.empty()) return fail(refusal);
  fail(describe_end_of(end));
}

void ProcessRun::fail(const std::string& failure) {
  if (!failure_.empty()) return;
  failure_ = failure;
  progress_.clear();
  std::fprintf(stderr, "hrp-simulate: %s; the run stops\n", failure.c_str());
}

void ProcessRun::show() {
  const msg::RunStatus status = monitor_->run_status();
  if (status.step() > 0) first_step_seen_ = true;
  for (const std::string& text : monitor_->take_messages()) {
    progress_.clear();
    std::fprintf(stderr, "%s\n", text.c_str());
  }
  note_wait(monitor_->has_heard_scheduler() ? status.late() : "scheduler");
  progress_.show(format_progress(status, scenario_.feet, monitor_->find_fall()));
}

void ProcessRun::end_all() {
  const auto begin = Clock::now();
  if (!has_ended()) monitor_->stop(failure_);
  bool asked = false;
  auto alone_since = Clock::time_point::max();
  while (children_.any_running()) {
    bus_->spin(std::chrono::milliseconds(5));
    look_at_remotes();
    while (children_.take_ended()) {
    }
    const auto waited = Clock::now() - begin;
    // Without a scheduler nobody passes the word on.
    const auto roles = children_.get_running_roles();
    const bool leaderless = !has_ended() && !has(roles, "scheduler");
    // The scheduler waits for goodbyes, which a dead server does not say.
    if (roles == std::vector<std::string>{"scheduler"}) alone_since = std::min(alone_since, Clock::now());
    const bool alone = Clock::now() - std::min(alone_since, Clock::now()) > kLastWords;
    if (!asked && (waited > kOrderlyEnd || leaderless || alone)) {
      asked = true;
      children_.send_signal(SIGTERM);
    }
    if (waited > kTermPatience) {
      for (const std::string& role : roles) {
        std::fprintf(stderr, "hrp-simulate: %s does not end; killed\n", role.c_str());
        if (role == "logger" && failure_.empty()) failure_ = "the logger had not closed its file";
      }
      children_.send_signal(SIGKILL);
    }
  }
  progress_.clear();
}

RunOutcome ProcessRun::make_outcome() {
  const msg::RunStatus status = monitor_->run_status();
  RunOutcome outcome;
  outcome.failure = failure_;
  if (failure_.empty() && status.phase() == msg::RUN_FAILED) {
    outcome.failure = status.message();
    std::fprintf(stderr, "hrp-simulate: %s (at step %llu)\n", status.message().c_str(),
                 static_cast<unsigned long long>(status.step()));
  }
  if (outcome.failure.rfind("model_parser: model refused", 0) == 0) bad_input_ = true;
  outcome.exit_code = outcome.failure.empty() ? kExitOk : bad_input_ ? kExitBadInput : kExitFailed;
  outcome.wall_time = std::chrono::duration<double>(Clock::now() - monitor_->find_first_step(start_)).count();
  outcome.parts = monitor_->find_parts();
  if (finished_ && outcome.parts.empty())
    outcome.parts = {static_cast<double>(monitor_->find_step_of_end("dynamics")) * scenario_.time_step};
  outcome.logs = monitor_->find_logs();
  outcome.viewer = viewer_;
  return outcome;
}

}  // namespace

void wait_for_viewer(const RunOutcome& outcome) {
  if (!outcome.viewer || g_stop_signal || !outcome.viewer->any_running()) return;
  if (isatty(STDOUT_FILENO) == 1) {
    std::printf("The page shows the recorded run now. Ctrl-C ends the viewer.\n");
    while (!g_stop_signal && !outcome.viewer->take_ended()) usleep(50000);
  }
  outcome.viewer->send_signal(SIGTERM);
}

RunOutcome run_as_processes(const LaunchOptions& options, const Scenario& scenario, const std::string& log) {
  ProcessRun run(options, scenario, log);
  return run.run();
}

}  // namespace hrp
