// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/monitor.h"

#include <unistd.h>

#include <cstdio>

#include "common/base/format.h"
#include "common/base/printable.h"
#include "common/messages/topics.h"
#include "common/node/run_token.h"

namespace hrp {
RunMonitor::RunMonitor(Bus& bus, std::string token, const std::vector<std::string>& robots)
    : bus_(bus), token_(std::move(token)), control_(bus, topics::kRunControl) {
  readers_.push_back(subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable,
                                               [this](const msg::RunStatus& status) { take(status); }));
  listen_for_falls("");
  for (const std::string& robot : robots) listen_for_falls(robot);
  readers_.push_back(subscribe<msg::ServerStatus>(bus, topics::kServerStatus, Delivery::kReliable,
                                                  [this](const msg::ServerStatus& status) { take(status); }));
}

void RunMonitor::listen_for_falls(const std::string& robot) {
  const TopicSpec topic = topics::of_robot(topics::kEvents, robot);
  readers_.push_back(
      subscribe<msg::RobotEvent>(bus_, topic, Delivery::kReliable, [this, robot](const msg::RobotEvent& event) {
        if (event.kind() != msg::EVENT_FALL) return;
        fall_ = event.header();
        fallen_ = robot;
      }));
}

void RunMonitor::take(const msg::ServerStatus& status) {
  if (!first_step_ && status.server() == "dynamics" && status.step() > 0) first_step_ = Clock::now();
  servers_[status.server()] = status;
  if (!status.file().empty() && (logs_.empty() || logs_.back() != status.file())) logs_.push_back(status.file());
  if (status.phase() == msg::SERVER_FAULT || status.message().empty()) return;
  const std::string text = make_printable(status.server() + ": " + status.message());
  if (said_.insert(text).second) messages_.push_back(text);
}

void RunMonitor::take(const msg::RunStatus& status) {
  if (!may_believe(token_, run_status_, status)) return;
  run_status_ = status;
  run_status_.message(make_printable(status.message()));
  run_status_.late(make_printable_line(status.late()));
  heard_scheduler_ = true;
  if (status.step() > 0) part_ends_[status.epoch()] = status.time();
}

std::vector<double> RunMonitor::find_parts() const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  std::vector<double> parts;
  for (const auto& [epoch, end] : part_ends_) parts.push_back(end);
  return parts;
}

std::string RunMonitor::find_fall() const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  if (fall_.step() == 0 || fall_.epoch() != run_status_.epoch()) return "";
  char text[60];
  std::snprintf(text, sizeof text, "fell at t = %.3f s", fall_.time());
  return fallen_.empty() ? text : fallen_ + " " + text;
}

std::vector<std::string> RunMonitor::find_logs() const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  return logs_;
}

msg::RunStatus RunMonitor::run_status() const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  return run_status_;
}

bool RunMonitor::has_ended() const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  return is_over(run_status_);
}

bool RunMonitor::has_heard_scheduler() const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  return heard_scheduler_;
}

RunMonitor::Clock::time_point RunMonitor::find_first_step(Clock::time_point otherwise) const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  return first_step_.value_or(otherwise);
}

uint64_t RunMonitor::find_step_of_end(const std::string& role) const {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  const auto found = servers_.find(role == "logger" ? role : "dynamics");
  return found == servers_.end() ? 0 : found->second.step();
}

std::vector<std::string> RunMonitor::take_messages() {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  std::vector<std::string> taken;
  taken.swap(messages_);
  return taken;
}

void RunMonitor::stop(const std::string& reason) {
  std::lock_guard<std::recursive_mutex> lock(bus_.mutex());
  msg::RunControl control;
  control.request(msg::REQUEST_STOP);
  control.reason(reason);
  control.nonce(make_nonce());
  sign(token_, topics::kRunControl.type_name, &control);
  control_.publish(control);
}

std::string format_progress(const msg::RunStatus& status, const std::vector<std::string>& feet,
                            const std::string& fall) {
  std::string line = format("%-8s t = %8.3f s", get_phase_text(status.phase()), status.time());
  if (status.end_time() > 0.0) line += format(" of %g s", status.end_time());
  line += format("  %5.1f x real time", status.real_time_factor());
  for (size_t i = 0; i < status.foot_forces().size(); ++i) {
    const std::string name = i < feet.size() ? make_printable_line(feet[i]) : "foot " + std::to_string(i);
    line += format("  %s %6.1f N", name.c_str(), status.foot_forces()[i]);
  }
  if (!fall.empty()) line += "  " + fall;
  if (!status.late().empty()) line += "  waits for " + status.late();
  return line;
}

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDOUT_FILENO) == 1) {}

void ProgressLine::show(const std::string& line) {
  const auto now = Clock::now();
  const auto period = terminal_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(2000);
  if (quiet_ || now - last_ < period) return;
  last_ = now;
  if (terminal_) {
    std::printf("\r\033[K%s", line.c_str());
    drawn_ = true;
  } else {
    std::printf("%s\n", line.c_str());
  }
  std::fflush(stdout);
}

void ProgressLine::clear() {
  if (drawn_) std::printf("\r\033[K");
  drawn_ = false;
  std::fflush(stdout);
}

}  // namespace hrp
