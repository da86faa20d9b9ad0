// SPDX-License-Identifier: BSD-3-Clause
// A server on a bus. Nodes only react: bus callbacks do the work, on_idle() does what silence asks for.
#pragma once

#include <chrono>
#include <string>

#include "common/bus/bus.h"

namespace hrp {

// Role of the controller of a robot: "controller.partner", "controller" for the scenario's first robot ("").
inline std::string make_controller_role(const std::string& robot) {
  return robot.empty() ? "controller" : "controller." + robot;
}
// "partner" of "controller.partner"; empty for all other roles.
inline std::string find_robot_of(const std::string& role) {
  const std::string start = make_controller_role("x");
  return role.compare(0, start.size() - 1, start, 0, start.size() - 1) == 0 ? role.substr(start.size() - 1) : "";
}
inline bool is_controller(const std::string& role) {
  return role == make_controller_role("") || !find_robot_of(role).empty();
}

// What a node needs to know about the run it joins, from the command line of its process.
struct NodeContext {
  Bus* bus = nullptr;
  std::string role;     // "dynamics"
  std::string program;  // "hrp-dynamics"
  std::string token;    // of the run (run_token.h), empty when it has none
  // Of a controller: its robot where a scenario has several, empty for the scenario's first one
  std::string robot = {};
};

enum class NodeOutcome { kRunning, kFinished, kFailed };

class Node {
 public:
  virtual ~Node() = default;
  // Called by the runner without the bus's mutex, at the start and then at idle times: the place to make readers and
  // writers. A bus may hold locks of its own while it waits for its mutex to call back, so making them under the mutex
  // can end in a deadlock.
  virtual void make_endpoints() {}
  // The counterpart, after the end and also without the mutex: no callback comes any more when it returns. A destructor
  // would be too late, as it ends the derived node first and the readers of its base after that.
  virtual void drop_endpoints() {}
  // Called every idle_period() or so, under the bus's mutex: repeats, time-outs, pacing.
  virtual void on_idle(std::chrono::steady_clock::time_point now) = 0;
  virtual std::chrono::milliseconds idle_period() const { return std::chrono::milliseconds(10); }
  virtual NodeOutcome outcome() const = 0;
  // Clean end asked for (SIGINT, SIGTERM): finish what is at hand, then outcome() != kRunning.
  virtual void request_stop() = 0;
  // Why outcome() is kFailed.
  virtual std::string failure() const = 0;
  // Whoever watches the run has been told of the failure: the program need not say it again.
  virtual bool has_told_failure() const { return false; }
  // What this node needs and has not got: "sensor_data from dynamics". Empty when nothing is missing.
  virtual std::string find_missing() const { return ""; }
};

}  // namespace hrp
