// SPDX-License-Identifier: BSD-3-Clause
#include "servers/scheduler/step_scheduler.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "common/base/has.h"

namespace hrp {
namespace {

// Those that the run waits for when they are among its roles: their step says what they have done with.
constexpr const char* kFollowers[] = {"logger", "vision"};
// Grants stay within this many windows of what is on disk, or has been seen; writers keep more samples than that.
constexpr uint64_t kFollowWindows = 8;
// Dynamics says something every quarter of a second in any case: this long without a word is silence.
constexpr auto kSilence = std::chrono::milliseconds(600);
// Nobody leaves before the log has the last step, so that what got lost on its way can be sent again; but a logger that
// stays silent for this long is not waited for. It then says itself what its file misses.
constexpr auto kFollowPatience = std::chrono::seconds(20);
// A run that is stopped does the steps that were granted, and its log gets them. It is over after this time in any
// case.
constexpr auto kStopPatience = std::chrono::seconds(2);

// A run that is slower looks like one that hangs; the clock would not notice one that is faster.
constexpr double kLeastSpeed = 1e-3, kMostSpeed = 1e6;
constexpr uint64_t kMostSteps = 1000000;

}  // namespace

std::string find_speed_fault(double speed) {
  if (speed == 0.0 || (speed >= kLeastSpeed && speed <= kMostSpeed)) return "";
  char text[120];
  std::snprintf(text, sizeof text, "speed is %g, expected 0.001 to 1e6 simulated seconds per second, or 0 for no limit",
                speed);
  return text;
}

std::string find_duration_fault(double duration) {
  if (duration >= 0.0 && duration <= 1e9) return "";
  char text[80];
  std::snprintf(text, sizeof text, "duration is %g s, expected 0 to 1e9 s of simulated time", duration);
  return text;
}

StepScheduler::StepScheduler(const SchedulerOptions& options)
    : options_(options), paused_(options.paused), speed_(options.speed) {}

void StepScheduler::set_run(double time_step, uint64_t end_step) {
  if (stopping_) return;
  time_step_ = time_step;
  end_step_ = end_step;
}

bool StepScheduler::is_waited_for(const std::string& role) const { return has(options_.roles, role); }

void StepScheduler::take_report(const ServerReport& report, Clock::time_point now) {
  if (report.role == "dynamics") take_dynamics_report(report, now);
  reports_[report.role] = report;
  if (report.state != ServerState::kFault) return;
  // A logger may find out while it closes its file, after a run that went well.
  if (state_ == RunState::kFinished) state_ = RunState::kRunning;
  const std::string role = report.role.empty() ? "a server without a name" : report.role;
  request_stop(role + ": " + (report.message.empty() ? "failed without a reason" : report.message));
}

void StepScheduler::take_dynamics_report(const ServerReport& report, Clock::time_point now) {
  heard_dynamics_ = now;
  if (grant_.process_id == 0) {
    // The first one we hear. A scheduler that was restarted joins the epoch that runs.
    grant_.process_id = report.process_id;
    grant_.epoch = report.epoch;
    grant_.through_step = report.step;
  } else if (report.process_id != grant_.process_id) {
    if (report.state == ServerState::kStopped) return;
    grant_.process_id = report.process_id;
    start_epoch(grant_.epoch + 1);
  }
  if (report.epoch == grant_.epoch) step_ = report.step;
}

void StepScheduler::start_epoch(uint64_t epoch) {
  grant_.epoch = epoch;
  grant_.through_step = 0;
  grant_.last = false;
  started_ = false;
  pace_started_ = false;
  step_ = 0;
  at_end_ = false;
  paused_at_ = 0;
}

std::string StepScheduler::request_run(std::optional<double> speed, Clock::time_point now) {
  std::string fault = find_speed_fault(speed.value_or(0.0));
  if (!fault.empty()) return fault;
  paused_ = false;
  speed_ = speed.value_or(speed_);
  restart_pace(now);
  return "";
}

void StepScheduler::request_pause() {
  if (paused_) return;
  paused_ = true;
  paused_at_ = grant_.through_step;  // what was granted cannot be taken back
}

std::string StepScheduler::request_steps(uint64_t steps) {
  if (steps < 1 || steps > kMostSteps) return "asked for " + std::to_string(steps) + " steps, expected 1 to 1000000";
  request_pause();
  paused_at_ += steps;
  return "";
}

void StepScheduler::request_reset() {
  if (!stopping_) start_epoch(grant_.epoch + 1);
}

void StepScheduler::request_stop(const std::string& reason) {
  if (state_ == RunState::kFinished || state_ == RunState::kFailed) return;
  failure_ = reason;
  state_ = reason.empty() ? RunState::kFinished : RunState::kFailed;
}

// What was granted cannot be taken back: its last step is the last one of the run, as if it had been planned so.
void StepScheduler::request_end(Clock::time_point now) {
  const bool follower = has(kFollowers, late_);
  const bool somebody_missing = !late_.empty() && !follower;
  if (stopping_ || !started_ || grant_.through_step == 0 || somebody_missing) return request_stop("");
  stopping_ = true;
  stop_time_ = now;
  end_step_ = grant_.through_step;
}

void StepScheduler::restart_pace(Clock::time_point now) {
  pace_started_ = true;
  pace_time_ = now;
  pace_step_ = grant_.through_step;
}

bool StepScheduler::is_ready() {
  if (started_) return true;
  if (time_step_ <= 0.0) return false;
  for (const std::string& role : options_.roles) {
    const auto found = reports_.find(role);
    if (found == reports_.end() || found->second.state != ServerState::kReady) return false;
    if (role == "dynamics" && found->second.epoch != grant_.epoch) return false;
  }
  started_ = true;
  return true;
}

std::vector<StepScheduler::Follower> StepScheduler::find_followers() const {
  std::vector<Follower> followers;
  for (const char* role : kFollowers) {
    if (!is_waited_for(role)) continue;
    const auto found = reports_.find(role);
    const bool known = found != reports_.end() && found->second.epoch == grant_.epoch;
    const uint64_t step = known ? found->second.step : 0;
    followers.push_back({role, step, step + kFollowWindows * options_.window});
  }
  return followers;
}

uint64_t StepScheduler::find_limit(Clock::time_point now) const {
  uint64_t limit = step_ + 2 * options_.window;
  for (const Follower& follower : find_followers()) limit = std::min(limit, follower.limit);
  if (end_step_ > 0) limit = std::min(limit, end_step_);
  if (paused_) return std::min(limit, paused_at_);
  if (speed_ > 0.0 && pace_started_) {
    const double elapsed = std::chrono::duration<double>(now - pace_time_).count();
    limit = std::min(limit, pace_step_ + static_cast<uint64_t>(elapsed * speed_ / time_step_));
  }
  return limit;
}

std::string StepScheduler::find_late(Clock::time_point now) const {
  if (time_step_ <= 0.0) return "model_parser";
  const auto dynamics = reports_.find("dynamics");
  if (dynamics == reports_.end()) return "dynamics";
  if (state_ == RunState::kPaused) return "";
  if (now - heard_dynamics_ > kSilence) return "dynamics";
  if (!dynamics->second.waiting_for.empty()) return dynamics->second.waiting_for;
  if (!started_) {
    for (const std::string& role : options_.roles) {
      const auto found = reports_.find(role);
      if (found == reports_.end() || found->second.state != ServerState::kReady) return role;
    }
  }
  for (const Follower& follower : find_followers()) {
    if (step_ >= follower.limit || (at_end_ && now - end_time_ > kSilence && follower.step < end_step_))
      return follower.role;
  }
  return "";
}

bool StepScheduler::is_over(Clock::time_point now) {
  if (end_step_ == 0 || !started_ || step_ < end_step_) return false;
  if (!at_end_) end_time_ = now;
  at_end_ = true;
  if (now - end_time_ > kFollowPatience) return true;
  const std::vector<Follower> followers = find_followers();
  return std::all_of(followers.begin(), followers.end(),
                     [this](const Follower& follower) { return follower.step >= end_step_; });
}

void StepScheduler::update(Clock::time_point now) {
  if (state_ == RunState::kFinished || state_ == RunState::kFailed) return;
  if (grant_.process_id == 0 || !is_ready()) {
    state_ = RunState::kWaiting;
  } else {
    if (!pace_started_) restart_pace(now);
    grant_.through_step = std::max(grant_.through_step, find_limit(now));
    grant_.last = end_step_ > 0 && grant_.through_step == end_step_;
    state_ = paused_ && step_ >= grant_.through_step ? RunState::kPaused : RunState::kRunning;
  }
  if (is_over(now) || (stopping_ && now - stop_time_ > kStopPatience)) request_stop("");
  late_ = state_ == RunState::kFinished ? "" : find_late(now);
}

}  // namespace hrp
