// SPDX-License-Identifier: BSD-3-Clause
#include "servers/scheduler/node.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "common/base/diagnostics.h"
#include "common/messages/convert_robot.h"
#include "common/messages/topics.h"
#include "common/robot/scenario.h"

namespace hrp {
namespace {

constexpr auto kStatusPeriod = std::chrono::milliseconds(100);
// After the end of the run the scheduler stays until everybody has said goodbye, but no longer than this.
constexpr auto kGoodbyePatience = std::chrono::milliseconds(1500);
// The logger writes what is still on its way, to a disk that may be slow.
constexpr auto kLoggerPatience = std::chrono::seconds(20);

ServerState find_state(msg::ServerPhase phase) {
  switch (phase) {
    case msg::SERVER_READY: return ServerState::kReady;
    case msg::SERVER_FAULT: return ServerState::kFault;
    case msg::SERVER_STOPPED: return ServerState::kStopped;
    default: return ServerState::kStarting;
  }
}

msg::RunPhase find_phase(RunState state) {
  switch (state) {
    case RunState::kRunning: return msg::RUN_RUNNING;
    case RunState::kPaused: return msg::RUN_PAUSED;
    case RunState::kFinished: return msg::RUN_FINISHED;
    case RunState::kFailed: return msg::RUN_FAILED;
    default: return msg::RUN_WAITING;
  }
}

std::string join_refusals(const msg::ModelRefused& message) {
  std::string text = "model_parser: model refused";
  for (const msg::ModelRefusal& refusal : message.refusals()) {
    text += "\n" + refusal.file();
    if (refusal.line() > 0) text += ":" + std::to_string(refusal.line());
    text += ": error: ";
    if (!refusal.element().empty()) text += refusal.element() + ": ";
    text += refusal.reason();
  }
  return text;
}

// Larger than any number of a scheduler that ran before on this machine, which counted on from the time of its start.
uint64_t find_first_push_number() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

}  // namespace

SchedulerNode::SchedulerNode(const NodeContext& context, const SchedulerOptions& options, double duration_override,
                             bool ros_services)
    : NodeBase(context, /*follows_run=*/false),
      scheduler_(options),
      duration_override_(duration_override),
      grant_publisher_(bus(), topics::kStepGrant),
      status_publisher_(bus(), topics::kRunStatus),
      pushes_(find_first_push_number()),
      offers_ros_services_(ros_services) {
  listen<msg::ServerStatus>(topics::kServerStatus,
                            [this](const msg::ServerStatus& m) { attempt([&] { take_status(m); }); });
  listen<msg::RunControl>(topics::kRunControl, [this](const msg::RunControl& m) { attempt([&] { take_control(m); }); });
  listen<msg::RobotDescription>(topics::kRobotDescription,
                                [this](const msg::RobotDescription& m) { attempt([&] { take_description(m); }); });
  listen<msg::ModelRefused>(topics::kModelRefused,
                            [this](const msg::ModelRefused& m) { attempt([&] { take_refusal(m); }); });
  set_phase(msg::SERVER_READY);
}

void SchedulerNode::make_endpoints() {
  NodeBase::make_endpoints();
  if (!offers_ros_services_ || ros_services_) return;
  ros_services_ = std::make_unique<RosServices>(bus(), [this](msg::RunRequest request) { return steer(request); });
}

void SchedulerNode::drop_endpoints() {
  ros_services_.reset();
  NodeBase::drop_endpoints();
}

void SchedulerNode::take_description(const msg::RobotDescription& message) {
  const Scenario scenario = parse_scenario(message.scenario(), message.scenario_path());
  const double duration = duration_override_ >= 0.0 ? duration_override_ : scenario.duration;
  RobotDescription robot;
  from_message(message, &robot);
  tree_ = robot.tree;
  movers_ = make_movers(robot, scenario);
  const auto steps = static_cast<uint64_t>(std::llround(duration / scenario.time_step));
  scheduler_.set_run(scenario.time_step, duration > 0.0 ? std::max<uint64_t>(steps, 1) : 0);  // 0: without an end
  update();
}

void SchedulerNode::take_refusal(const msg::ModelRefused& message) {
  scheduler_.request_stop(join_refusals(message));
  update();
}

void SchedulerNode::take_status(const msg::ServerStatus& message) {
  if (message.server() == context().role) return;
  if (message.phase() == msg::SERVER_FAULT && !is_authorized(topics::kServerStatus, message)) return;
  alive_[message.server()] = message.phase() != msg::SERVER_STOPPED && message.phase() != msg::SERVER_FAULT;
  ServerReport report;
  report.role = message.server();
  report.process_id = message.process_id();
  report.state = find_state(message.phase());
  report.epoch = message.epoch();
  report.step = message.step();
  report.waiting_for = message.waiting_for();
  report.message = message.message();
  scheduler_.take_report(report, Clock::now());
  if (message.server() == "dynamics") {
    status_.foot_forces() = message.foot_forces();
    if (message.phase() != msg::SERVER_FAULT) status_.message(message.message());
  }
  update();
}

void SchedulerNode::handle_decode_error(const std::string& topic, const std::string& reason) {
  // Whoever writes what is no request has not signed it either.
  if (topic == topics::kRunControl.name && !context().token.empty()) return say_unauthorized(topic);
  attempt([&] { throw std::runtime_error(topic + ": " + reason); });
}

// Nobody watches the scheduler: what it cannot do ends the run, or all others would wait for it.
void SchedulerNode::attempt(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    scheduler_.request_stop(context().role + ": " + error.what());
    publish_status(Clock::now());
  }
}

void SchedulerNode::answer(const std::string& refused) {
  status_.refused(refused);
  publish_status(Clock::now());
  status_.refused("");
}

// Not signed: those who hold the token must not take it for an answer to a request of theirs.
void SchedulerNode::answer_stranger(const std::string& refused) {
  if (has_ended()) return;
  update_status(Clock::now());
  msg::RunStatus status = status_;
  status.refused(refused);
  status.signature("");
  status_publisher_.publish(status);
}

std::string SchedulerNode::follow(const msg::RunControl& message) {
  switch (message.request()) {
    case msg::REQUEST_RUN:
      return scheduler_.request_run(message.change_speed() ? std::optional<double>(message.speed()) : std::nullopt,
                                    Clock::now());
    case msg::REQUEST_PAUSE: scheduler_.request_pause(); return "";
    case msg::REQUEST_STEP: return scheduler_.request_steps(message.steps());
    case msg::REQUEST_RESET: scheduler_.request_reset(); return "";
    case msg::REQUEST_PUSH: return push(message.push());
    case msg::REQUEST_STOP: request_stop(message.reason()); return "";
    default: return "no such request: " + std::to_string(static_cast<int>(message.request()));
  }
}

std::string SchedulerNode::push(const msg::Push& push) {
  if (has_ended()) return "the run has ended";
  if (tree_.links.empty()) return "the robot is not known yet";
  std::string fault = find_push_fault(push, tree_, movers_);
  if (fault.empty()) pushes_.add(push);
  return fault;
}

void SchedulerNode::take_control(const msg::RunControl& message) {
  if (!is_authorized(topics::kRunControl, message)) {
    return answer_stranger(
        "only the user who started this run may steer it: the request is not signed with the run's token");
  }
  // Without a token, people write requests by hand, who know no nonce.
  const bool by_hand = context().token.empty() && message.nonce() == 0;
  if (!by_hand && !used_nonces_.take(message.nonce())) return;
  const std::string refused = follow(message);
  status_.answered(message.nonce());
  update();
  answer(refused);
}

SteerResult SchedulerNode::steer(msg::RunRequest request) {
  if (has_ended()) return {false, "the run has ended"};
  msg::RunControl message;
  message.request(request);
  message.steps(1);
  SteerResult result;
  attempt([&] {
    const std::string refused = follow(message);
    update();
    answer(refused);
    const bool stops = request == msg::REQUEST_PAUSE || request == msg::REQUEST_STEP;
    const std::string done = stops ? "stops after step " + std::to_string(scheduler_.paused_at()) : "";
    result = {refused.empty(), refused.empty() ? done : refused};
  });
  return result;
}

void SchedulerNode::request_stop() {
  if (has_ended()) gone_ = true;  // asked to go while it waits for the others
  request_stop("");
  update();
}

void SchedulerNode::request_stop(const std::string& reason) {
  if (reason.empty()) return scheduler_.request_end(Clock::now());
  scheduler_.request_stop(reason);
}

bool SchedulerNode::has_ended() const {
  return scheduler_.state() == RunState::kFinished || scheduler_.state() == RunState::kFailed;
}

void SchedulerNode::update() {
  const auto now = Clock::now();
  scheduler_.update(now);
  const Grant& grant = scheduler_.grant();
  const bool moved = grant.epoch != granted_.epoch || grant.process_id != granted_.process_id ||
                     grant.through_step != granted_.through_step || grant.last != granted_.last;
  // Half a window at least, unless that would let dynamics wait: fewer messages.
  const uint64_t ahead = granted_.through_step > scheduler_.step() ? granted_.through_step - scheduler_.step() : 0;
  const bool soon =
      grant.epoch != granted_.epoch || grant.process_id != granted_.process_id || ahead < 96 || grant.last;
  if (grant.process_id != 0 && moved && soon && !has_ended()) {
    if (grant.epoch != granted_.epoch) pushes_.reset();
    msg::StepGrant message;
    message.pushes(pushes_.give_out(grant.epoch == granted_.epoch ? granted_.through_step : 0, scheduler_.step()));
    granted_ = grant;
    message.epoch(grant.epoch);
    message.through_step(grant.through_step);
    message.last(grant.last);
    message.for_process(static_cast<int32_t>(grant.process_id));
    sign(context().token, topics::kStepGrant.type_name, &message);
    grant_publisher_.publish(message);
  }
  const msg::RunPhase phase = find_phase(scheduler_.state());
  if (phase != status_.phase() || scheduler_.late() != status_.late()) publish_status(now);
}

double SchedulerNode::calc_real_time_factor(Clock::time_point now) {
  if (progress_epoch_ != scheduler_.epoch()) progress_.clear();
  progress_epoch_ = scheduler_.epoch();
  progress_.emplace_back(now, scheduler_.step());
  while (progress_.size() > 2 && now - progress_.front().first > std::chrono::seconds(1)) progress_.pop_front();
  const double elapsed = std::chrono::duration<double>(now - progress_.front().first).count();
  if (elapsed <= 0.0) return 0.0;
  return static_cast<double>(scheduler_.step() - progress_.front().second) * scheduler_.time_step() / elapsed;
}

void SchedulerNode::update_status(Clock::time_point now) {
  status_.phase(find_phase(scheduler_.state()));
  status_.epoch(scheduler_.epoch());
  status_.step(scheduler_.step());
  status_.time(static_cast<double>(scheduler_.step()) * scheduler_.time_step());
  status_.end_time(static_cast<double>(scheduler_.end_step()) * scheduler_.time_step());
  status_.real_time_factor(calc_real_time_factor(now));
  status_.late(scheduler_.late());
  status_.speed(scheduler_.speed());
  if (scheduler_.state() == RunState::kFailed) status_.message(scheduler_.failure());
}

void SchedulerNode::publish_status(Clock::time_point now) {
  last_status_ = now;
  update_status(now);
  status_.signature("");
  if (must_be_signed(status_)) sign(context().token, topics::kRunStatus.type_name, &status_);
  status_publisher_.publish(status_);
}

bool SchedulerNode::is_everybody_gone() const {
  for (const auto& [role, alive] : alive_) {
    if (alive) return false;
  }
  return true;
}

void SchedulerNode::handle_idle(Clock::time_point now) {
  attempt([&] { look(now); });
}

void SchedulerNode::look(Clock::time_point now) {
  update();
  if (now - last_status_ > kStatusPeriod) publish_status(now);
  report(scheduler_.epoch(), 0);
  if (!has_ended()) return;
  if (!ended_) {
    ended_ = true;
    end_time_ = now;
  }
  const auto logger = alive_.find("logger");
  const bool logging = logger != alive_.end() && logger->second;
  if (is_everybody_gone() || now - end_time_ > (logging ? Clock::duration(kLoggerPatience) : kGoodbyePatience))
    gone_ = true;
}

NodeOutcome SchedulerNode::outcome() const {
  if (!gone_ && NodeBase::failure().empty()) return NodeOutcome::kRunning;
  if (!gone_) return NodeBase::outcome();
  return scheduler_.state() == RunState::kFailed ? NodeOutcome::kFailed : NodeOutcome::kFinished;
}

}  // namespace hrp
