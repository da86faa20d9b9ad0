// SPDX-License-Identifier: BSD-3-Clause
// Who may step how far: readiness, windows, pauses, pacing, resets and ends of a run. No bus; time comes as a
// parameter.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace hrp {

enum class ServerState { kStarting, kReady, kFault, kStopped };

struct ServerReport {
  std::string role;
  long process_id = 0;
  ServerState state = ServerState::kStarting;
  uint64_t epoch = 0;
  uint64_t step = 0;
  std::string waiting_for;
  std::string message;
};

struct Grant {
  uint64_t epoch = 0;
  uint64_t through_step = 0;
  bool last = false;
  long process_id = 0;  // of the dynamics server that is meant
};

enum class RunState { kWaiting, kRunning, kPaused, kFinished, kFailed };

struct SchedulerOptions {
  std::vector<std::string> roles;  // that must be ready before the first step: dynamics, logger, ...
  uint64_t window = 64;            // [steps] of a grant while the run is not paced
  double speed = 0.0;              // [s/s] simulated against real time, 0 = as fast as it goes
  bool paused = false;             // wait for a request before the first step
};

// Why a run cannot be held to this speed [s/s]; empty when it can. 0 is as fast as it goes.
std::string find_speed_fault(double speed);

// Why a run cannot last this long [s]; empty when it can. 0 is until it is stopped.
std::string find_duration_fault(double duration);

class StepScheduler {
 public:
  using Clock = std::chrono::steady_clock;

  explicit StepScheduler(const SchedulerOptions& options);

  // Once the scenario is known. end_step 0: until stopped.
  void set_run(double time_step, uint64_t end_step);
  void take_report(const ServerReport& report, Clock::time_point now);
  // Without a speed: at the pace it had. Returns why the speed is refused, else nothing.
  [[nodiscard]] std::string request_run(std::optional<double> speed, Clock::time_point now);
  void request_pause();
  // Returns why the number is refused, else nothing.
  [[nodiscard]] std::string request_steps(uint64_t steps);
  void request_reset();
  // At once. Empty reason: a normal end.
  void request_stop(const std::string& reason);
  // A normal end after the steps that were granted, with all of them in the log; at once when that cannot be, or asked
  // again.
  void request_end(Clock::time_point now);

  // What is granted now, and the state of the run. update() first.
  void update(Clock::time_point now);
  const Grant& grant() const { return grant_; }
  RunState state() const { return state_; }
  const std::string& late() const { return late_; }
  // Last step before the pause that was asked for last.
  uint64_t paused_at() const { return paused_at_; }
  const std::string& failure() const { return failure_; }
  uint64_t epoch() const { return grant_.epoch; }
  uint64_t step() const { return step_; }
  uint64_t end_step() const { return end_step_; }
  double time_step() const { return time_step_; }
  double speed() const { return speed_; }

 private:
  bool is_waited_for(const std::string& role) const;
  void take_dynamics_report(const ServerReport& report, Clock::time_point now);
  void start_epoch(uint64_t epoch);
  void restart_pace(Clock::time_point now);
  bool is_ready();
  uint64_t find_limit(Clock::time_point now) const;
  // A role that the run waits for, with how far the others may go for it.
  struct Follower {
    std::string role;
    uint64_t step = 0;  // of this epoch that it has done with
    uint64_t limit = 0;
  };
  std::vector<Follower> find_followers() const;
  std::string find_late(Clock::time_point now) const;
  // The last step has been reached, and it is on disk when the run is logged (or was waited for long enough).
  bool is_over(Clock::time_point now);

  SchedulerOptions options_;
  double time_step_ = 0.0;  // [s] 0: not known yet
  uint64_t end_step_ = 0;
  std::map<std::string, ServerReport> reports_;
  RunState state_ = RunState::kWaiting;
  Grant grant_;
  bool started_ = false;  // of this epoch: everybody has been ready
  bool paused_ = false;
  uint64_t paused_at_ = 0;  // while paused: no step beyond this one
  double speed_ = 0.0;
  bool pace_started_ = false;
  Clock::time_point pace_time_;
  uint64_t pace_step_ = 0;
  uint64_t step_ = 0;           // last one that dynamics reported
  bool at_end_ = false;         // of this epoch: that was the last one
  Clock::time_point end_time_;  // since when
  bool stopping_ = false;       // request_end() was called
  Clock::time_point stop_time_;
  Clock::time_point heard_dynamics_;
  std::string late_;
  std::string failure_;
};

}  // namespace hrp
