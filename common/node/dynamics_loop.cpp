// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/dynamics_loop.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/base/diagnostics.h"
#include "common/messages/convert_robot.h"
#include "common/messages/topics.h"

namespace hrp {
namespace {

// A quarter of the scheduler's window, see docs/step_protocol.md.
constexpr uint64_t kReportPeriod = 16;

bool is_finite(const Vector3d& v) { return std::isfinite(v.x() + v.y() + v.z()); }

}  // namespace

DynamicsLoop::DynamicsLoop(const NodeContext& context, EngineFactory make_engine, double ros_rate)
    : NodeBase(context),
      make_engine_(std::move(make_engine)),
      state_publisher_(bus(), topics::kRobotState),
      forces_publisher_(bus(), topics::kContactForces),
      log_samples_(bus()),
      ros_rate_(ros_rate),
      view_(bus()) {
  listen<msg::StepGrant>(topics::kStepGrant, [this](const msg::StepGrant& m) { take_grant(m); });
  listen<msg::ContactSet>(topics::kContactSet,
                          [this](const msg::ContactSet& m, Bytes sample) { take_contacts(m, sample); });
  listen<msg::JointCommands>(topics::kJointCommands, [this](const msg::JointCommands& m) { take_commands(0, m); });
  listen<msg::RobotDescription>(topics::kRobotDescription,
                                [this](const msg::RobotDescription& m) { take_description(m); });
  robots_.resize(1);
  robots_[0].publisher = Publisher<msg::SensorData>(bus(), topics::kSensorData);
  robots_[0].events = Publisher<msg::RobotEvent>(bus(), topics::kEvents);
}

void DynamicsLoop::take_description(const msg::RobotDescription& message) {
  if (engine_) return;  // a restarted model parser says the same again
  from_message(message, &robot_);
  scenario_ = parse_scenario(robot_.scenario, robot_.scenario_path);
  names_ = BodyNames(robot_, scenario_);
  movers_ = make_movers(robot_, scenario_);
  engine_ = make_engine();
  add_robots();
  if (in_epoch_) start_epoch(epoch_);
}

void DynamicsLoop::add_robots() {
  if (engine_->num_other_robots() != scenario_.robots.size()) {
    throw InputError(
        scenario_.make_diagnostic("robots", "this dynamics server simulates no other robots; use hrp-dynamics"));
  }
  const std::vector<Mover> bodies = make_robots(robot_, scenario_, movers_);
  robots_.resize(bodies.size());
  for (size_t k = 0; k < bodies.size(); ++k) {
    const Mover& body = robots_[k].body = bodies[k];
    robots_[k].log_topic = topics::of_robot(topics::kSensorData, body.name).name;
    robots_[k].gate = CommandGate(body.robot.tree, body.scenario.controller, make_controller_role(body.name));
    robots_[k].fall_watch = FallWatch(body.robot, body.scenario, body.name);
  }
  other_efforts_.resize(robots_.size() - 1);
  ros_samples_.resize(robots_.size());
}

// What a scheduler that counts right cannot say; empty when it can.
std::string DynamicsLoop::find_wrong_grant(const msg::StepGrant& grant) const {
  const uint64_t epoch = in_epoch_ ? epoch_ : 0;
  if (grant.epoch() > epoch && grant.epoch() - epoch > kMostEpochsAhead) {
    return "names epoch " + std::to_string(grant.epoch()) + ", this run is at epoch " + std::to_string(epoch);
  }
  const uint64_t step = in_epoch_ && grant.epoch() == epoch_ ? step_ : 0;
  if (grant.through_step() > step && grant.through_step() - step > kMostGranted && grant.epoch() >= epoch) {
    return "allows steps up to " + std::to_string(grant.through_step()) + " at step " + std::to_string(step) +
           ", more than the " + std::to_string(kMostGranted) + " that a scheduler grants ahead";
  }
  if (has_last_ && grant.epoch() == epoch_ && grant.through_step() > last_step_) {
    return "allows step " + std::to_string(grant.through_step()) + " after it had said that step " +
           std::to_string(last_step_) + " is the last";
  }
  for (const msg::Push& push : grant.pushes()) {
    const std::string fault = engine_ ? find_push_fault(push, robot_.tree, movers_) : find_push_fault(push);
    if (!fault.empty()) return "asks for a push that cannot be: " + fault;
  }
  return "";
}

// Engines know keys and not where they stand.
std::unique_ptr<DynamicsEngine> DynamicsLoop::make_engine() const {
  try {
    return make_engine_(robot_, scenario_);
  } catch (const InputError& error) {
    Diagnostics placed;
    for (const Diagnostic& d : error.diagnostics())
      placed.add_error(d.file.empty() ? scenario_.make_diagnostic(d.field, d.message) : d);
    throw InputError(placed);
  }
}

void DynamicsLoop::take_grant(const msg::StepGrant& grant) {
  if (!is_authorized(topics::kStepGrant, grant)) return;
  if (grant.for_process() != static_cast<int32_t>(getpid())) return;  // meant for one that is no more
  const std::string wrong = find_wrong_grant(grant);
  if (!wrong.empty()) return fail("step_grant " + wrong);
  if (!in_epoch_ || grant.epoch() > epoch_) {
    epoch_ = grant.epoch();
    in_epoch_ = true;
    granted_ = grant.through_step();
    has_last_ = false;
    pushes_.reset();
    if (engine_) start_epoch(epoch_);
  } else if (grant.epoch() == epoch_ && grant.through_step() > granted_) {
    granted_ = grant.through_step();
  }
  if (grant.epoch() == epoch_) {
    for (const msg::Push& push : grant.pushes()) pushes_.add(push);
  }
  if (grant.epoch() == epoch_ && grant.last()) {
    has_last_ = true;
    last_step_ = grant.through_step();
  }
  advance();
}

void DynamicsLoop::start_epoch(uint64_t epoch) {
  engine_->reset();
  step_ = 0;
  have_contacts_ = false;
  contacts_sample_.clear();
  for (size_t k = 0; k < robots_.size(); ++k) robots_[k].gate.reset(epoch, get_state(k).q);
  set_phase(msg::SERVER_STARTING);
  publish_step();
  report(epoch_, step_, find_missing());
}

void DynamicsLoop::take_contacts(const msg::ContactSet& message, Bytes sample) {
  if (!engine_ || !in_epoch_ || message.header().epoch() != epoch_) return;
  if (message.header().step() > step_) {
    return fail("collision_checker answered step " + std::to_string(message.header().step()) +
                " before it was asked; the question was step " + std::to_string(step_));
  }
  if (message.header().step() < step_ || have_contacts_) return;  // a repeat
  contacts_sample_.assign(sample.data, sample.data + sample.size);
  log_samples_.add(topics::kContactSet.name, sample);  // also when it is wrong: the log shows what came
  from_message(message, &contacts_);
  if (!check_contacts(contacts_)) return;
  have_contacts_ = true;
  advance();
  if (step_ == granted_) log_samples_.flush();
}

bool DynamicsLoop::check_contacts(const ContactSet& contacts) {
  for (const ContactPair& pair : contacts) {
    bool good = pair.body_a >= 0 && names_.contains(pair.body_a) && names_.contains(pair.body_b) &&
                is_finite(pair.separation) && is_finite(pair.separation_turn) && is_finite(pair.p_WR) &&
                std::isfinite(pair.friction);
    for (const ContactPoint& point : pair.points) {
      good = good && is_finite(point.p_WC) && is_finite(point.n_BA_W) && std::isfinite(point.depth);
    }
    if (good) continue;
    fail("collision_checker sent a contact between bodies " + std::to_string(pair.body_a) + " and " +
         std::to_string(pair.body_b) + " that cannot be (unknown body or a number that is not finite) at step " +
         std::to_string(step_));
    return false;
  }
  return true;
}

void DynamicsLoop::take_commands(size_t robot, const msg::JointCommands& message) {
  if (!engine_ || !in_epoch_) return;
  CommandGate& gate = robots_[robot].gate;
  if (!gate.take(message)) return fail(gate.fault());
  say_warning();
  advance();
}

void DynamicsLoop::take_garbage(size_t robot, const std::string& reason) {
  CommandGate& gate = robots_[robot].gate;
  if (!gate.take_garbage("sent a message that is none: " + reason)) return fail(gate.fault());
  advance();
}

bool DynamicsLoop::have_answers() const {
  return std::all_of(robots_.begin(), robots_.end(), [](const Controlled& robot) { return robot.gate.has_answer(); });
}

void DynamicsLoop::command_others() {
  for (size_t k = 1; k < robots_.size(); ++k) engine_->command_other(k - 1, robots_[k].gate.command());
}

// Once more when the last one is over, so that the engine lets go.
void DynamicsLoop::push() {
  if (pushes_.empty()) return;
  const PushForces acting = pushes_.find(step_);
  if (engine_->push(acting) || pushes_ignored_) return;
  pushes_ignored_ = true;
  say_warning();
}

void DynamicsLoop::handle_decode_error(const std::string& topic, const std::string& reason) {
  // Whoever writes what is no grant has not signed it either.
  if (topic == topics::kStepGrant.name && !context().token.empty()) return say_unauthorized(topic);
  if (topic != topics::kJointCommands.name) return fail(topic + ": " + reason);
  take_garbage(0, reason);
}

void DynamicsLoop::advance() {
  if (!engine_ || !in_epoch_) return;
  while (can_step()) {
    if (is_control_step()) command_others();
    push();
    const std::string fault = engine_->step(contacts_, robots_[0].gate.command());
    if (!fault.empty()) return fail("step " + std::to_string(step_) + ": " + fault);
    ++step_;
    have_contacts_ = false;
    publish_step();
    if (step_ % kReportPeriod == 0 || step_ == granted_) report(epoch_, step_);
  }
  if (step_ == 0 && have_contacts_ && have_answers()) set_phase(msg::SERVER_READY);
}

msg::Header DynamicsLoop::make_header() const {
  msg::Header header;
  header.epoch(epoch_);
  header.step(step_);
  header.time(static_cast<double>(step_) * scenario_.time_step);
  return header;
}

// The state first: the collision checker starts on it while the rest is still being sent.
void DynamicsLoop::publish_step() {
  state_message_.header(make_header());
  to_message(engine_->state(), engine_->joint_efforts(), engine_->state_hash(), &state_message_);
  for (size_t k = 0; k < other_efforts_.size(); ++k) other_efforts_[k] = engine_->other_efforts(k);
  to_message(engine_->objects(), other_efforts_, scenario_, &state_message_);
  to_message(engine_->pushes(), &state_message_);
  last_state_ = state_publisher_.publish(state_message_);
  if (step_ % kReportPeriod == 0) log_samples_.look_for_reader();
  log_samples_.add(topics::kRobotState.name, last_state_);
  if (is_control_step()) publish_sensors();
  forces_message_.header(state_message_.header());
  to_message(engine_->contact_forces(), names_, &forces_message_);
  last_forces_ = forces_publisher_.publish(forces_message_);
  log_samples_.add(topics::kContactForces.name, last_forces_);
  // Samples of several steps go as one packet, here or at the next idle time.
  if (step_ == granted_ || step_ % kReportPeriod == 0) flush_gathered();
  set_foot_forces(engine_->foot_forces());
  for (size_t k = 0; k < robots_.size(); ++k) watch_fall(k);
  if (view_.is_due()) show_step();
}

void DynamicsLoop::watch_fall(size_t robot) {
  FallWatch& watch = robots_[robot].fall_watch;
  const State& state = get_state(robot);
  if (step_ == 0) watch.reset(state.R_WB, state.p_WB);
  if (step_ == 0 || !watch.is_due(state.R_WB, state.p_WB)) return;
  const std::optional<FallEvent> event = watch.update(find_own_forces(engine_->contact_forces(), robots_[robot].body));
  if (!event) return;
  msg::RobotEvent message;
  message.header(state_message_.header());
  to_message(*event, &message);
  robots_[robot].events.publish(message);
  char time[40];
  std::snprintf(time, sizeof time, "t = %.3f s: ", message.header().time());
  if (event->fall) say(time + event->text);
}

void DynamicsLoop::show_step() {
  view_.add(topics::kRobotState.name, last_state_);
  view_.add(topics::kSensorData.name, robots_[0].last);
  view_.add(topics::kContactForces.name, last_forces_);
}

// The last step of a run is the one that people look at longest.
void DynamicsLoop::handle_run_end() {
  flush_gathered();
  if (!view_.is_watched()) return;
  show_step();
  view_.flush();
}

void DynamicsLoop::flush_gathered() {
  forces_publisher_.flush();
  log_samples_.flush();
}

void DynamicsLoop::publish_sensors() {
  for (size_t k = 0; k < robots_.size(); ++k) {
    Controlled& robot = robots_[k];
    robot.message.header(state_message_.header());
    to_message(get_sensors(k), robot.body.scenario.sensors, &robot.message);
    robot.gate.note_asked(step_, Clock::now());
    robot.last = robot.publisher.publish(robot.message);
    log_samples_.add(robot.log_topic, robot.last);
    ros_samples_[k] = {&robot.message, &get_state(k)};
  }
  ros_views_.publish(ros_samples_);
}

void DynamicsLoop::repeat_last() {
  state_publisher_.publish_bytes(last_state_);
  forces_publisher_.publish_bytes(last_forces_);
  log_samples_.update_readers();
  log_samples_.add(topics::kRobotState.name, last_state_);
  log_samples_.add(topics::kContactForces.name, last_forces_);
  if (have_contacts_) log_samples_.add(topics::kContactSet.name, {contacts_sample_.data(), contacts_sample_.size()});
  for (Controlled& robot : robots_) {
    robot.gate.note_asked(robot.message.header().step(), Clock::now());
    robot.publisher.publish_bytes(robot.last);
    log_samples_.add(robot.log_topic, robot.last);
  }
  flush_gathered();
}

std::string DynamicsLoop::find_missing() const {
  if (!engine_) return "model_parser";
  if (!in_epoch_) return "scheduler";
  if (!have_contacts_) return "collision_checker";
  for (const Controlled& robot : robots_) {
    if (!robot.gate.has_answer()) return make_controller_role(robot.body.name);
  }
  return "";
}

void DynamicsLoop::say_warning() {
  std::string warning = pushes_ignored_ ? "this dynamics server takes no pushes; use hrp-dynamics" : "";
  for (const Controlled& robot : robots_) {
    if (!robot.gate.warning().empty()) warning += (warning.empty() ? "" : "\n") + robot.gate.warning();
  }
  if (warning == warning_said_) return;
  warning_said_ = warning;
  say(warning_said_);
}

// Once it is known which other robots there are. Nobody has asked their controllers for anything before.
void DynamicsLoop::make_other_endpoints() {
  for (size_t k = 1; k < robots_.size(); ++k) {
    Controlled& robot = robots_[k];
    Publisher<msg::SensorData> publisher(bus(), topics::of_robot(topics::kSensorData, robot.body.name));
    Publisher<msg::RobotEvent> events(bus(), topics::of_robot(topics::kEvents, robot.body.name));
    auto reader = subscribe<msg::JointCommands>(
        bus(), topics::of_robot(topics::kJointCommands, robot.body.name), Delivery::kReliable,
        [this, k](const msg::JointCommands& m) {
          if (is_active()) guard([&] { take_commands(k, m); });
        },
        [this, k](const DecodeError& error) {
          if (is_active()) take_garbage(k, error.what());
        });
    std::lock_guard<std::recursive_mutex> lock(bus().mutex());
    robot.publisher = std::move(publisher);
    robot.events = std::move(events);
    robot.reader = std::move(reader);
    if (!in_epoch_) continue;
    robot.last = robot.publisher.publish(robot.message);
    log_samples_.add(robot.log_topic, robot.last);
  }
}

void DynamicsLoop::drop_endpoints() {
  for (Controlled& robot : robots_) robot.reader.reset();
  NodeBase::drop_endpoints();
}

void DynamicsLoop::make_endpoints() {
  NodeBase::make_endpoints();
  if (ros_views_made_) return;
  {
    std::lock_guard<std::recursive_mutex> lock(bus().mutex());
    if (!engine_) return;
  }
  make_other_endpoints();
  // Robot and scenario do not change once there is an engine.
  RosViews views(bus(), make_robots(robot_, scenario_), ros_rate_);
  std::lock_guard<std::recursive_mutex> lock(bus().mutex());
  ros_views_ = std::move(views);
  ros_views_made_ = true;
}

// Silence: the same step as at the last look, and something is missing (or nobody has started yet, and may have missed
// the first messages).
void DynamicsLoop::handle_idle(Clock::time_point now) {
  if (!engine_ || !in_epoch_) return report(epoch_, step_, find_missing());
  ros_views_.update_readers();
  log_samples_.update_readers();
  flush_gathered();
  if (view_.update(now)) show_step();
  for (Controlled& robot : robots_) {
    if (!robot.gate.check_silence(now)) return fail(robot.gate.fault());
  }
  advance();
  if (!is_active()) return;
  say_warning();
  const bool moved = step_ != idle_step_ || epoch_ != idle_epoch_;
  const bool waiting = !have_contacts_ || !have_answers() || granted_ == 0;
  idle_step_ = step_;
  idle_epoch_ = epoch_;
  if (moved || !waiting) return repeat_timer_.restart(now);
  if (!repeat_timer_.is_due(now)) return;
  repeat_timer_.restart(now);
  report(epoch_, step_, find_missing());
  repeat_last();
}

}  // namespace hrp
