// SPDX-License-Identifier: BSD-3-Clause
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

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
#include "servers/model_parser/robot_loader.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;

// The reason of a stop is with the scheduler. It ends everybody within this time (after the steps that it granted, or two
// seconds), else signals do.
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

const char* get_default_program(const std::string& role) {
  if (role == "model_parser") return "hrp-model-parser";
  if (role == "scheduler") return "hrp-scheduler";
  if (role == "logger") return "hrp-logger";
  if (role == "dynamics") return "hrp-dynamics";
  if (role == "collision_checker") return "hrp-collision-checker";
  if (role == "vision") return "hrp-vision";
  return "hrp-controller";
}

std::string find_own_folder() {
  char path[PATH_MAX];
  const ssize_t size = readlink("/proc/self/exe", path, sizeof path);
  const std::string self(path, size > 0 ? static_cast<size_t>(size) : 0);
  return self.substr(0, self.find_last_of('/'));
}

// A name without a slash is a program of ours, beside this one.
std::string find_program(const std::string& name) {
  return name.find('/') == std::string::npos ? find_own_folder() + "/" + name : name;
}

// The same for a command of people's: where there is none of ours, the one that a shell would run.
std::string find_command(const std::string& name) {
  std::string own = find_program(name);
  const char* folders = std::getenv("PATH");
  if (access(own.c_str(), X_OK) == 0 || own == name || folders == nullptr) return own;
  std::istringstream list(folders);
  for (std::string folder; std::getline(list, folder, ':');) {
    std::string path = (folder.empty() ? "." : folder) + "/" + name;
    if (access(path.c_str(), X_OK) == 0) return path;
  }
  return own;
}

std::string get_file_name(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

std::string join_robots(const Scenario& scenario) {
  std::string names;
  for (const std::string& robot : list_robots(scenario)) names += (names.empty() ? "" : ",") + robot;
  return names;
}

std::vector<std::string> list_meshes(const RobotDescription& robot, bool visible) {
  std::vector<std::string> files;
  const auto add = [&files](const CollisionShape& shape) {
    if (!shape.mesh.empty()) files.push_back(shape.mesh);
  };
  if (!visible) std::for_each(robot.shapes.begin(), robot.shapes.end(), add);
  else for (const VisualShape& visual : robot.visuals) add(visual.shape);
  return files;
}

class ProcessRun {
 public:
  ProcessRun(const LaunchOptions& options, const Scenario& scenario, const std::string& log)
      : options_(options), scenario_(scenario), log_(log), progress_(options.quiet) {}

  RunOutcome run();

 private:
  bool is_left_out(const std::string& role) const {
    return std::find(options_.without.begin(), options_.without.end(), role) != options_.without.end();
  }
  // Nobody looks where there are no cameras and no lidars.
  bool is_needed(const std::string& role) const { return role != "vision" || scenario_.sensors.has_vision(); }
  std::vector<std::string> make_role_arguments(const std::string& role) const;
  ChildSpec make_child(const std::string& role) const;
  std::vector<std::string> find_files_of(const std::string& role) const;
  std::vector<std::string> find_motion(const std::string& robot) const;
  void start_remote(const std::string& role);
  void look_at_remotes();
  const RemoteServer* find_remote(const std::string& role) const;
  std::string describe_end_of(const ChildEnd& end) const;
  std::string make_join_command(const std::string& role) const;
  void note_wait(const std::string& late);
  std::vector<int> find_cores_of(const std::string& role) const;
  void start_all();
  void start_viewer();
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
  Clock::time_point start_, first_step_;
};

std::vector<int> ProcessRun::find_cores_of(const std::string& role) const {
  // Processes that take turns are fastest on one core: a wake-up across cores costs several times a switch on one.
  const std::vector<int> cores = find_cores();
  if (!options_.pin || cores.size() < 2) return {};
  const size_t loop_core = static_cast<size_t>(claim_.domain()) % cores.size();  // runs side by side spread out
  const bool in_loop = role == "dynamics" || role == "collision_checker" || is_controller(role);
  std::vector<int> chosen;
  for (size_t i = 0; i < cores.size(); ++i) {
    if ((i == loop_core) == in_loop) chosen.push_back(cores[i]);
  }
  return chosen;
}

// What a server of this run is told beside the place where it meets the others.
std::vector<std::string> ProcessRun::make_role_arguments(const std::string& role) const {
  std::vector<std::string> arguments;
  if (role == "model_parser") arguments.push_back(options_.scenario);
  if (role == "model_parser" && options_.verbose) arguments.push_back("--verbose");
  if (role == "dynamics" && options_.ros_rate > 0.0) arguments.insert(arguments.end(), {"--ros-rate", std::to_string(options_.ros_rate)});
  if (role == "logger") arguments.insert(arguments.end(), {"--log", log_});
  if (role == "logger" && !scenario_.robots.empty()) arguments.insert(arguments.end(), {"--robots", join_robots(scenario_)});
  if (!find_robot_of(role).empty()) arguments.insert(arguments.end(), {"--robot", find_robot_of(role)});
  if (role == "logger" && options_.force) arguments.push_back("--force");
  if (role == "logger" && options_.durable) arguments.push_back("--durable");
  if (role != "scheduler") return arguments;
  std::string waited_for = is_left_out("logger") ? "dynamics" : "dynamics,logger";
  if (scenario_.sensors.every_picture && is_needed("vision")) waited_for += ",vision";
  arguments.insert(arguments.end(), {"--wait-for", waited_for});
  arguments.insert(arguments.end(), {"--speed", std::to_string(options_.speed)});
  if (options_.duration >= 0.0) arguments.insert(arguments.end(), {"--duration", std::to_string(options_.duration)});
  if (options_.paused) arguments.push_back("--paused");
  if (options_.ros_services) arguments.push_back("--ros-services");
  return arguments;
}

ChildSpec ProcessRun::make_child(const std::string& role) const {
  const auto program = options_.programs.find(role);
  const auto vendor = options_.dds_for.find(role);
  ChildSpec child;
  child.role = role;
  const auto command = options_.commands.find(role);
  const bool is_command = command != options_.commands.end();
  auto& arguments = child.arguments;
  if (is_command) {
    arguments = command->second;
    arguments[0] = find_command(arguments[0]);
  } else {
    arguments = {find_program(program == options_.programs.end() ? get_default_program(role) : program->second)};
  }
  arguments.insert(arguments.end(), {"--domain", std::to_string(claim_.domain()), "--dds",
                                     vendor == options_.dds_for.end() ? options_.dds : vendor->second});
  // They then leave it to us to say what went wrong.
  const bool ours = program == options_.programs.end() && !is_command;
  if (ours) arguments.insert(arguments.end(), {"--parent", std::to_string(getpid())});
  if (!options_.secure.empty()) arguments.insert(arguments.end(), {"--secure", options_.secure});
  const std::vector<std::string> own = make_role_arguments(role);
  arguments.insert(arguments.end(), own.begin(), own.end());
  child.cores = find_cores_of(role);
  return child;
}

// Robot and scenario come over the bus. What comes from files are meshes and the motion that a controller plays.
std::vector<std::string> ProcessRun::find_files_of(const std::string& role) const {
  if (is_controller(role)) return find_motion(find_robot_of(role));
  if (role == "dynamics" && options_.programs.count(role) == 0) return {};
  const RobotDescription robot = load_robot(scenario_);
  std::vector<std::string> files = list_meshes(robot, role == "vision");
  for (const OtherRobot& other : robot.robots) {
    for (const std::string& file : list_meshes(other.description, role == "vision")) files.push_back(file);
  }
  return files;
}

// The file that a controller plays: of another robot, or of the first one (""). None or one.
std::vector<std::string> ProcessRun::find_motion(const std::string& robot) const {
  Scenario scenario = scenario_;
  for (const RobotPlacement& placement : scenario_.robots) {
    if (placement.name == robot) scenario = load_scenario(placement.scenario);
  }
  return scenario.controller.type == "motion" ? std::vector<std::string>{scenario.controller.motion} : std::vector<std::string>{};
}

void ProcessRun::start_remote(const std::string& role) {
  RemoteCommand command;
  command.role = role;
  command.host = options_.on.at(role);
  command.token = claim_.entry().token;
  command.files = find_files_of(role);
  const auto program = options_.programs.find(role);
  const auto vendor = options_.dds_for.find(role);
  std::string path = program == options_.programs.end() ? get_default_program(role) : program->second;
  if (path.find('/') == std::string::npos) path = (command.host.programs.empty() ? find_own_folder() : command.host.programs) + "/" + path;
  command.arguments = {path, "--domain", std::to_string(claim_.domain()), "--dds", vendor == options_.dds_for.end() ? options_.dds : vendor->second,
                       "--far-launcher", "--network-interface", turn_network(claim_.entry().network, find_address(command.host))};
  for (const std::string& word : make_role_arguments(role)) command.arguments.push_back(word);
  if (!options_.secure.empty()) {
    command.arguments.insert(command.arguments.end(), {"--secure", command.host.secure.empty() ? std::filesystem::absolute(options_.secure).string() : command.host.secure});
    command.files.push_back(command.arguments.back());
  }
  remotes_.push_back(std::make_unique<RemoteServer>(command));
  std::vector<std::string> ssh = options_.ssh;
  ssh[0] = find_command(ssh[0]);
  remotes_.back()->start(ssh, &children_);
}

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
  return end.role + " (" + end.program + ", process " + std::to_string(end.process_id) + ") " + describe_end(end.status) + step;
}

void ProcessRun::start_all() {
  claim_ = options_.domain >= 0 ? claim_domain(options_.domain, options_.scenario) : claim_free_domain(options_.scenario);
  RunEntry entry = claim_.entry();
  entry.vendor = options_.dds;
  entry.network = options_.on.empty() ? "" : find_network(options_.on);
  entry.token = make_run_token();
  entry.log = is_left_out("logger") ? "" : log_;
  entry.free_places = options_.without;
  entry.secured = !options_.secure.empty();
  claim_.describe(entry);
  // Children first: this process has no threads yet.
  for (const std::string& role : list_roles(scenario_)) {
    if (is_left_out(role) || !is_needed(role)) continue;
    if (options_.on.count(role) > 0) {
      start_remote(role);
    } else {
      children_.start(make_child(role));
    }
  }
  if (options_.view) start_viewer();
  BusOptions bus;
  bus.secure = options_.secure;
  bus.vendor = options_.dds;
  bus.domain = claim_.domain();
  bus.network_interface = claim_.entry().network;
  bus_ = make_bus(bus);
  monitor_ = std::make_unique<RunMonitor>(*bus_, claim_.entry().token, list_robots(scenario_));
}

void ProcessRun::start_viewer() {
  ChildSpec child;
  child.role = "viewer";
  child.arguments = {find_program("hrp-viewer"), "--domain", std::to_string(claim_.domain()), "--dds", options_.dds,
                     "--port", std::to_string(options_.view_port), "--then", log_};
  if (!options_.secure.empty()) child.arguments.insert(child.arguments.end(), {"--secure", options_.secure});
  viewer_ = std::make_shared<Children>();
  viewer_->start(child);
}

// A command line that takes a free place, whatever else runs on this machine.
std::string ProcessRun::make_join_command(const std::string& role) const {
  // The template of the tree: with our own controller there would have been no need to leave the place free.
  std::string command = find_own_folder() + "/" + (is_controller(role) ? "my-controller" : get_default_program(role));
  if (access(command.c_str(), X_OK) != 0) command = "scripts/build.sh " + get_file_name(command) + " && " + command;
  command += " --run " + std::to_string(getpid());
  if (!options_.secure.empty()) command += " --secure " + quote_word(options_.secure);
  for (const std::string& word : make_role_arguments(role)) command += " " + quote_word(word);
  return command;
}

void ProcessRun::say_what_is_missing() {
  for (const std::string& role : options_.without) {
    std::printf("The place of %s is free, on DDS domain %d (%s). To join from another terminal:\n  %s\n", role.c_str(),
                claim_.domain(), options_.dds.c_str(), make_join_command(role).c_str());
    if (is_controller(role)) {
      std::printf("  source: controller/template/my_controller.cpp; any program that reads %s and answers each\n"
                  "  sample with %s of the same epoch and step will do (docs/client_in_c.md)\n",
                  topics::of_robot(topics::kSensorData, find_robot_of(role)).name.c_str(),
                  topics::of_robot(topics::kJointCommands, find_robot_of(role)).name.c_str());
    }
  }
  std::fflush(stdout);
}

void ProcessRun::say_who_can_listen() const {
  if (options_.on.empty() || !options_.secure.empty()) return;
  std::fprintf(stderr, "hrp-simulate: warning: this run leaves the machine without encryption; everybody on that network can read it and\n"
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
  if (!waits || !is_left_out(late) || !first_step_seen_) return;  // at the start it was said
  progress_.clear();
  std::printf("waits for %s; to join: %s\n", late.c_str(), make_join_command(late).c_str());
  std::fflush(stdout);
}

RunOutcome ProcessRun::run() {
  start_ = first_step_ = Clock::now();
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
  std::fprintf(stderr, "hrp-simulate: the viewer (%s, process %d) %s; the run goes on without it\n", end.program.c_str(),
               static_cast<int>(end.process_id), describe_end(end.status).c_str());
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
  if (Clock::now() - since < (ends_well(end) ? Clock::duration(kFinishPatience) : Clock::duration(kReasonPatience))) return;
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
  if (!first_step_seen_ && status.step() > 0) {
    first_step_seen_ = true;
    first_step_ = Clock::now();
  }
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
    const bool leaderless = !has_ended() && std::find(roles.begin(), roles.end(), "scheduler") == roles.end();
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
  outcome.wall_time = std::chrono::duration<double>(Clock::now() - first_step_).count();
  outcome.parts = monitor_->find_parts();
  if (finished_ && outcome.parts.empty()) outcome.parts = {static_cast<double>(monitor_->find_step_of_end("dynamics")) * scenario_.time_step};
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
