// SPDX-License-Identifier: BSD-3-Clause
// What the launcher knows of the run: reports of servers and scheduler, and a way to stop it.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/messages/pubsub.h"
#include "hrp_idl/dynamics.h"
#include "hrp_idl/scheduling.h"

namespace hrp {

class RunMonitor {
 public:
  using Clock = std::chrono::steady_clock;

  // `robots`: names of the robots beside the first one.
  explicit RunMonitor(Bus& bus, std::string token = "", const std::vector<std::string>& robots = {});
  // Copies, safe from any thread.
  msg::RunStatus run_status() const;
  bool has_ended() const;
  bool has_heard_scheduler() const;
  // When dynamics first reported steps; `otherwise` before that.
  Clock::time_point find_first_step(Clock::time_point otherwise) const;
  // The last step that dynamics reported; for the logger: the last one it had on disk.
  uint64_t find_step_of_end(const std::string& role) const;
  // What servers have said (warnings, not faults) since the last call: "dynamics: ...".
  std::vector<std::string> take_messages();
  // [s] simulated time that each epoch reached, in their order.
  std::vector<double> find_parts() const;
  // The files that the logger has written, in their order.
  std::vector<std::string> find_logs() const;
  // "fell at t = 3.214 s", "partner fell at t = 3.214 s" since the last reset, else nothing.
  std::string find_fall() const;
  // Empty reason: a normal end.
  void stop(const std::string& reason);

 private:
  void take(const msg::ServerStatus& status);
  void take(const msg::RunStatus& status);
  void listen_for_falls(const std::string& robot);

  Bus& bus_;
  std::string token_;  // of the run
  Publisher<msg::RunControl> control_;
  msg::RunStatus run_status_;
  bool heard_scheduler_ = false;
  std::optional<Clock::time_point> first_step_;
  std::map<std::string, msg::ServerStatus> servers_;
  std::map<uint64_t, double> part_ends_;  // [s] by epoch
  std::vector<std::string> logs_;
  msg::Header fall_;    // of the last fall; step 0: none
  std::string fallen_;  // the robot
  std::set<std::string> said_;
  std::vector<std::string> messages_;
  std::vector<std::unique_ptr<Reader>> readers_;
};

// The line of progress: simulated time, real-time factor, vertical force of each foot, who is late,
// and a fall.
std::string format_progress(const msg::RunStatus& status, const std::vector<std::string>& feet,
                            const std::string& fall);

// Draws the line over and over on a terminal, and every few seconds elsewhere.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  void show(const std::string& line);
  // Before anything else is written.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  Clock::time_point last_{};
};

}  // namespace hrp
