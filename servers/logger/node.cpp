// SPDX-License-Identifier: BSD-3-Clause
#include "servers/logger/node.h"

#include <algorithm>
#include <cstdio>

#include "common/base/diagnostics.h"
#include "common/base/printable.h"
#include "common/messages/convert_robot.h"
#include "common/messages/reflection/schema.h"
#include "common/messages/topics.h"
#include "common/robot/scenario.h"
#include "hrp_idl/model.h"

namespace hrp {
namespace {

// Looks (of 10 ms and more) until something that has not come is given up. Looks and not time: a process that was
// stopped for a while has not looked. Steps count as late when they are two windows old.
constexpr uint64_t kLateSteps = 128;
// Commands that the scenario lets the controller leave out: a second. Shorter would mistake a controller that the
// scheduler of the system let wait for a dead one.
constexpr int kHeldLooks = 100;
// What dynamics would not have gone on without was sent, and comes when its writer sends it again. On a machine where
// others had the processors, seconds passed until then. The scheduler waits for twice as long.
constexpr int kLostLooks = 1000;
// At the end of a run: nothing has come between so many looks, so nothing is on its way.
constexpr int kQuietLooks = 20;
// Nothing has come for so many looks: a second. Whoever speaks next may speak on other topics.
constexpr int kSilentLooks = 100;

// In the order in which they stand in the log within a step.
std::vector<TopicSpec> list_topics(const LoggerOptions& options) {
  std::vector<TopicSpec> list{topics::kRobotDescription, topics::kRobotState, topics::kContactForces,
                              topics::kSensorData,       topics::kContactSet, topics::kJointCommands};
  for (const std::string& robot : options.robots) {
    list.push_back(topics::of_robot(topics::kSensorData, robot));
    list.push_back(topics::of_robot(topics::kJointCommands, robot));
  }
  list.push_back(topics::kPictures);
  return list;
}

bool is_type(const TopicSpec& topic, const TopicSpec& type) { return topic.type_name == type.type_name; }

LogTopic make_log_topic(const TopicSpec& topic) {
  using Rate = LogTopic::Rate;
  const bool control = is_type(topic, topics::kSensorData) || is_type(topic, topics::kJointCommands);
  const Rate rate = is_type(topic, topics::kRobotDescription) ? Rate::kOnce
                    : is_type(topic, topics::kPictures)       ? Rate::kWhenDue
                    : control                                 ? Rate::kEveryControlStep
                                                              : Rate::kEveryStep;
  const bool answers = is_type(topic, topics::kContactSet) || is_type(topic, topics::kJointCommands) ||
                       is_type(topic, topics::kPictures);
  return {topic.name, topic.type_name, find_schema_text(topic.type_name), rate, answers};
}

// Who fills a topic, for messages: "controller.partner" for hrp/partner/joint_commands.
std::string find_role(const std::string& topic) {
  if (topic == topics::kRobotDescription.name) return "model_parser";
  if (topic == topics::kContactSet.name) return "collision_checker";
  if (topic == topics::kPictures.name) return "vision";
  return topics::find_known_topic(topic) == &topics::kJointCommands ? make_controller_role(topics::find_robot(topic))
                                                                    : "dynamics";
}

LogOptions make_log_options(const LoggerOptions& options) {
  LogOptions log;
  log.path = options.path;
  log.existing = options.force ? mcap::Existing::kReplace : mcap::Existing::kRefuse;
  log.durable = options.durable;
  for (const TopicSpec& topic : list_topics(options)) log.topics.push_back(make_log_topic(topic));
  return log;
}

// Said at the start, and not when the first step is over.
LogWriter make_log(const LoggerOptions& options) {
  try {
    if (!options.compression.empty()) mcap::parse_compression(options.compression);
    return LogWriter(make_log_options(options));
  } catch (const mcap::McapError& error) {
    refuse_input({""}, std::string("the log cannot be written: ") + error.what());
  }
}

}  // namespace

LoggerNode::LoggerNode(const NodeContext& context, const LoggerOptions& options)
    : NodeBase(context), options_(options), topics_(list_topics(options)), log_(make_log(options)) {
  listen<msg::StepGrant>(topics::kStepGrant, [this](const msg::StepGrant& grant) {
    if (!is_authorized(topics::kStepGrant, grant)) return;
    if (!grant.last()) return;
    const std::string wrong = find_wrong_end(grant);
    if (!wrong.empty()) return attempt([&wrong] { throw std::runtime_error("step_grant " + wrong); });
    last_known_ = true;
    any_last_ = true;
    last_epoch_ = grant.epoch();
    last_step_ = grant.through_step();
    attempt([this] { finish_when_complete(); });
    report_progress();
  });
}

// A last step that cannot be: the log would be closed too early, or never.
std::string LoggerNode::find_wrong_end(const msg::StepGrant& grant) const {
  const std::string named =
      "names step " + std::to_string(grant.through_step()) + " as the last of epoch " + std::to_string(grant.epoch());
  if (any_last_ && grant.epoch() == last_epoch_ && grant.through_step() != last_step_) {
    return named + ", after step " + std::to_string(last_step_);
  }
  if (grant.epoch() != log_.epoch() || !log_.has_first_step()) return "";
  const uint64_t newest = log_.newest_step();
  if (grant.through_step() < newest) return named + ", but step " + std::to_string(newest) + " is there";
  return "";
}

void LoggerNode::handle_decode_error(const std::string& topic, const std::string& reason) {
  // Whoever writes what is no grant has not signed it either.
  if (topic == topics::kStepGrant.name && !context().token.empty()) return say_unauthorized(topic);
  NodeBase::handle_decode_error(topic, reason);
}

// Called again and again.
void LoggerNode::make_endpoints() {
  NodeBase::make_endpoints();
  raw_readers_.resize(topics_.size());
  if (options_.gathered && !gathered_reader_) listen_gathered();
  bool gathered_comes = false, pictures = false;
  {
    std::lock_guard<std::recursive_mutex> lock(bus().mutex());
    gathered_comes = gathered_comes_;
    pictures = logs_pictures_;
  }
  for (size_t topic = 0; topic < topics_.size(); ++topic) {
    const bool wanted = is_type(topics_[topic], topics::kPictures) ? pictures : !gathered_comes || !is_gathered(topic);
    if (!wanted) raw_readers_[topic].reset();
    if (wanted && !raw_readers_[topic]) listen_raw(topic);
  }
}

// Whose samples dynamics sends in topics::kLogSamples: what it publishes, and the contacts that it got.
bool LoggerNode::is_gathered(size_t topic) const {
  const TopicSpec& spec = topics_[topic];
  return is_type(spec, topics::kRobotState) || is_type(spec, topics::kContactForces) ||
         is_type(spec, topics::kSensorData) || is_type(spec, topics::kContactSet);
}

void LoggerNode::listen_gathered() {
  gathered_reader_ = subscribe<msg::View>(
      bus(), topics::kLogSamples, Delivery::kReliable,
      [this](const msg::View& batch) {
        if (is_active()) attempt([&] { take_gathered(batch); });
      },
      [this](const DecodeError& error) {
        if (is_active()) handle_decode_error(topics::kLogSamples.name, error.what());
      });
}

void LoggerNode::take_gathered(const msg::View& batch) {
  for (const msg::ViewSample& sample : batch.samples()) {
    for (size_t topic = 1; topic < topics_.size(); ++topic) {
      if (!is_gathered(topic) || topics_[topic].name != sample.topic()) continue;
      log_.take(topic, sample.bytes().data(), sample.bytes().size());
    }
  }
  if (!gathered_from_) gathered_from_ = log_.newest_step();
  // A sample of an earlier step may be lost and still be sent again.
  gathered_comes_ = gathered_comes_ || log_.next_step() > *gathered_from_;
  finish_when_complete();
  report_progress();
}

void LoggerNode::drop_endpoints() {
  raw_readers_.clear();
  gathered_reader_.reset();
  NodeBase::drop_endpoints();
}

LoggerNode::~LoggerNode() = default;

void LoggerNode::listen_raw(size_t topic) {
  raw_readers_[topic] = bus().make_reader(topics_[topic], Delivery::kReliable, [this, topic](Bytes sample) {
    if (!is_active()) return;
    attempt([&] { topic == 0 ? take_description(sample) : take_sample(topic, sample); });
  });
}

void LoggerNode::attempt(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    std::string reason = error.what();
    if (log_.any_on_disk()) {
      reason += "; the log is readable and ends with step " + std::to_string(log_.step_on_disk());
    }
    report(log_.epoch(), log_.step_on_disk());
    fail(reason);
  }
}

void LoggerNode::take_description(Bytes sample) {
  msg::RobotDescription robot;
  decode(sample, &robot);
  const Scenario scenario = parse_scenario(robot.scenario(), robot.scenario_path());
  const std::string& word = options_.compression.empty() ? scenario.logging.compression : options_.compression;
  holds_ = scenario.controller.on_fault == "hold";
  watch_events(robot, scenario);
  watch_pictures(scenario);
  log_.set_description(sample.data, sample.size, scenario.control_period, mcap::parse_compression(word));
  report_progress();
}

// Events need a robot that fits together. One that does not is logged all the same: what was sent is never lost.
void LoggerNode::watch_events(const msg::RobotDescription& robot, const Scenario& scenario) {
  RobotDescription description;
  try {
    from_message(robot, &description);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "logger: no events in this log: %s\n", make_printable(error.what()).c_str());
    return;
  }
  event_finder_ = std::make_unique<EventFinder>(description, scenario);
  log_.set_events([this](const auto& state, const auto& forces) { return event_finder_->find(state, forces); });
}

// Whoever reads pictures makes the vision server take them, so only when they are asked for.
void LoggerNode::watch_pictures(const Scenario& scenario) {
  logs_pictures_ = scenario.logging.pictures && scenario.sensors.has_vision();
  if (!logs_pictures_) return;
  const auto is_due = [sensors = scenario.sensors, time_step = scenario.time_step,
                       period = scenario.control_period](uint64_t step) {
    return !find_looking_sensors(sensors.cameras, sensors.lidars, step, time_step, period).empty();
  };
  log_.set_parcels(is_due, unpack_pictures);
}

void LoggerNode::take_sample(size_t topic, Bytes sample) {
  log_.take(topic, sample.data, sample.size);
  finish_when_complete();
  report_progress();
}

// The scheduler ends the run when the last step is on disk.
void LoggerNode::finish_when_complete() {
  if (!last_known_ || last_epoch_ != log_.epoch() || !log_.is_complete_through(last_step_)) return;
  last_known_ = false;
  log_.finish_epoch();
}

void LoggerNode::report_progress() {
  const msg::ServerPhase phase = log_.has_first_step() ? msg::SERVER_READY : msg::SERVER_STARTING;
  if (!log_.files().empty() && log_.files().back() != status().file()) {
    set_file(log_.files().back());
    send_status();
  }
  if (phase == status().phase() && log_.epoch() == status().epoch() && log_.step_on_disk() == status().step()) return;
  report(log_.epoch(), log_.step_on_disk());
  set_phase(phase);
}

void LoggerNode::handle_idle(Clock::time_point) {
  quiet_looks_ = log_.sample_count() == last_sample_count_ ? quiet_looks_ + 1 : 0;
  last_sample_count_ = log_.sample_count();
  // Another dynamics server may have taken over, one that gathers nothing. A pause looks the same, and takes no harm.
  if (quiet_looks_ >= kSilentLooks) {
    gathered_from_.reset();
    gathered_comes_ = false;
  }
  late_looks_ = log_.next_step() == last_next_step_ && log_.backlog() >= kLateSteps ? late_looks_ + 1 : 0;
  last_next_step_ = log_.next_step();
  attempt([this] { log_.poll(); });
  if (!is_active()) return;
  report_progress();
  const bool lost = misses_what_was_sent();
  const bool at_end = last_known_ && last_epoch_ == log_.epoch() && log_.newest_step() >= last_step_;
  const bool given_up =
      late_looks_ >= (lost ? kLostLooks : kHeldLooks) || (at_end && quiet_looks_ >= (lost ? kLostLooks : kQuietLooks));
  if (!given_up) return;
  give_up_waiting();
  attempt([this] { finish_when_complete(); });
  report_progress();
}

// By the oldest step that is not written.
bool LoggerNode::misses_what_was_sent() const {
  const std::vector<std::string> missing = log_.find_missing();
  return std::any_of(missing.begin(), missing.end(), [this](const std::string& topic) {
    return !holds_ || topics::find_known_topic(topic) != &topics::kJointCommands;
  });
}

std::string LoggerNode::find_missing() const {
  return log_.has_first_step() ? "" : "the first step of dynamics, collision_checker and controller";
}

bool LoggerNode::is_quiet() const { return quiet_looks_ >= kQuietLooks; }

void LoggerNode::give_up_waiting() {
  const uint64_t step = log_.next_step();
  for (const std::string& topic : log_.give_up_waiting()) {
    say("no " + topic + " from " + find_role(topic) + " since step " + std::to_string(step) +
        "; the log goes on without it");
  }
}

bool LoggerNode::is_drained() {
  const msg::RunStatus& run = run_status();
  const bool last_step_known = run.phase() == msg::RUN_FINISHED && run.epoch() == log_.epoch();
  if (last_step_known && log_.is_complete_through(run.step())) return true;
  return is_quiet();
}

void LoggerNode::handle_run_end() {
  attempt([this] { log_.close(); });
  report(log_.epoch(), log_.step_on_disk());
  const msg::RunStatus& run = run_status();
  if (run.phase() != msg::RUN_FINISHED || run.epoch() != log_.epoch() || log_.step_on_disk() >= run.step()) return;
  fail("the run ended with step " + std::to_string(run.step()) + ", but nothing after step " +
       std::to_string(log_.step_on_disk()) + " reached the log");
}

}  // namespace hrp
