// SPDX-License-Identifier: BSD-3-Clause
// What dynamics accepts as an answer of the controller, and what it does about one that cannot be. No bus, no clock.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"
#include "hrp_idl/control.h"

namespace hrp {

class CommandGate {
 public:
  using Clock = std::chrono::steady_clock;

  CommandGate() = default;
  // `role`: of the controller, for messages.
  CommandGate(const TreeSpec& tree, const ControllerSpec& controller, const std::string& role = "controller");

  // Step 0 of an epoch: nothing is asked yet, `initial_q` is what is held when no good command ever comes.
  void reset(uint64_t epoch, const Eigen::VectorXd& initial_q);
  // Sensor data of `step` were sent (again).
  void note_asked(uint64_t step, Clock::time_point now);
  // Takes a message of the controller. False: it cannot be and the scenario says stop; fault() has the words.
  [[nodiscard]] bool take(const msg::JointCommands& message);
  // A message that was no message at all.
  [[nodiscard]] bool take_garbage(const std::string& reason) { return judge(reason); }
  // False when the controller has been silent for longer than the scenario allows, and that means stop.
  [[nodiscard]] bool check_silence(Clock::time_point now);

  // The answer to the last question is there, or the last good one is held in its place.
  bool has_answer() const { return answered_; }
  const JointCommand& command() const { return command_; }
  // Why take() or check_silence() said no.
  const std::string& fault() const { return fault_; }
  // What was overlooked because the scenario says hold; set once, with the first occasion.
  const std::string& warning() const { return warning_; }

 private:
  struct Asked {
    uint64_t step = 0;
    int asked = 0;
    int answered = 0;
    bool any = false;
  };

  std::string find_wrong_content(const msg::JointCommands& message) const;
  std::string find_wrong_array(const std::vector<double>& values, const char* name, bool required) const;
  bool take_old(const msg::JointCommands& message);
  bool judge(const std::string& reason);

  std::string role_ = "controller";
  std::vector<std::string> joints_;
  bool hold_ = false;
  double timeout_ = 0.0;  // [s] 0 = none
  uint64_t epoch_ = 0;
  Asked now_, before_;
  Clock::time_point asked_at_;
  bool answered_ = false;
  bool met_ = false;
  std::string stale_;        // an answer to another step has come since the last question
  uint64_t stale_step_ = 0;  // the step that it answered
  int stale_asked_ = 0;      // times that the question had been asked when such answers last came nearer to it
  bool silent_ = false;      // held because of silence: not waited for until it speaks
  JointCommand command_;
  msg::JointCommands last_, last_before_;  // answers accepted to now_ and before_
  std::string fault_, warning_;
};

}  // namespace hrp
