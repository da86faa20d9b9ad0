// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/command_gate.h"

#include <cmath>

#include "common/base/format.h"
#include "common/messages/convert.h"

namespace hrp {
namespace {

// Times that a question is asked again (50 ms apart) before answers to other steps, which come no nearer, count as its
// answer.
constexpr int kAskedBeforeStale = 4;

bool has_same_content(const msg::JointCommands& a, const msg::JointCommands& b) {
  return a.positions() == b.positions() && a.velocities() == b.velocities() && a.efforts() == b.efforts();
}

std::string format_seconds(double seconds) { return format("%g s", seconds); }

}  // namespace

CommandGate::CommandGate(const TreeSpec& tree, const ControllerSpec& controller, const std::string& role)
    : role_(role), hold_(controller.on_fault == "hold"), timeout_(controller.timeout) {
  for (int i = 0; i < tree.num_joints(); ++i) joints_.push_back(tree.joint(i).name);
}

void CommandGate::reset(uint64_t epoch, const Eigen::VectorXd& initial_q) {
  epoch_ = epoch;
  now_ = before_ = Asked{};
  answered_ = false;
  silent_ = false;
  command_ = JointCommand{};
  command_.q = initial_q;
  fault_.clear();
}

void CommandGate::note_asked(uint64_t step, Clock::time_point now) {
  if (now_.any && now_.step == step) {
    ++now_.asked;
    return;
  }
  before_ = now_;
  std::swap(last_before_, last_);
  now_ = Asked{step, 1, 0, true};
  asked_at_ = now;
  answered_ = silent_;
  stale_.clear();
}

bool CommandGate::take(const msg::JointCommands& message) {
  const uint64_t epoch = message.header().epoch(), step = message.header().step();
  if (epoch < epoch_ || (epoch == epoch_ && !now_.any)) return true;  // of a run that was reset
  if (epoch > epoch_) {
    return judge("answers epoch " + std::to_string(epoch) + ", this is epoch " + std::to_string(epoch_));
  }
  if (step < now_.step) return take_old(message);
  if (step > now_.step) {
    return judge("answers step " + std::to_string(step) + " before it was asked; the question was step " +
                 std::to_string(now_.step));
  }
  silent_ = false;
  if (++now_.answered > 1) {
    if (has_same_content(message, last_)) return true;
    return judge("gave two different answers to step " + std::to_string(step) + " (are there two controllers?)");
  }
  last_ = message;
  const std::string wrong = find_wrong_content(message);
  if (!wrong.empty()) return judge(wrong + " at step " + std::to_string(step));
  if (answered_) return true;  // too late: something was held in its place
  from_message(message, &command_);
  answered_ = true;
  met_ = true;
  return true;
}

// Not a fault at once: answers to repeated questions may come late, and a controller that has just joined may work its
// way through questions that a bus kept for it. One that has a wrong idea of the step never gets to the right answer;
// check_silence() finds out.
bool CommandGate::take_old(const msg::JointCommands& message) {
  const uint64_t step = message.header().step();
  if (before_.any && step == before_.step && has_same_content(message, last_before_) &&
      ++before_.answered <= before_.asked + 1) {
    return true;
  }
  if (stale_.empty() || step > stale_step_) stale_asked_ = now_.asked;
  stale_step_ = step;
  stale_ = "answered step " + std::to_string(step) + " when asked for step " + std::to_string(now_.step) +
           " (stale step number)";
  return true;
}

bool CommandGate::check_silence(Clock::time_point now) {
  if (!answered_ && now_.any && !stale_.empty() && now_.asked >= stale_asked_ + kAskedBeforeStale) return judge(stale_);
  if (answered_ || timeout_ <= 0.0 || !met_ || !now_.any) return true;
  if (std::chrono::duration<double>(now - asked_at_).count() < timeout_) return true;
  silent_ = hold_;
  return judge("has not answered step " + std::to_string(now_.step) + " for " + format_seconds(timeout_) +
               " (controller.timeout)");
}

std::string CommandGate::find_wrong_content(const msg::JointCommands& message) const {
  std::string wrong = find_wrong_array(message.positions(), "positions", true);
  if (wrong.empty()) wrong = find_wrong_array(message.velocities(), "velocities", false);
  if (wrong.empty()) wrong = find_wrong_array(message.efforts(), "efforts", false);
  return wrong;
}

std::string CommandGate::find_wrong_array(const std::vector<double>& values, const char* name, bool required) const {
  if (values.empty() && !required) return "";
  if (values.size() != joints_.size()) {
    return "sent " + std::to_string(values.size()) + " " + name + ", the robot has " + std::to_string(joints_.size()) +
           " joints";
  }
  for (size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    return std::string("sent ") + (std::isnan(values[i]) ? "NaN" : "an infinite value") + " in " + name +
           " of joint '" + joints_[i] + "'";
  }
  return "";
}

bool CommandGate::judge(const std::string& reason) {
  const std::string text = role_ + " " + reason;
  if (!hold_) {
    fault_ = text;
    return false;
  }
  answered_ = true;
  if (warning_.empty()) warning_ = text + ": the last good commands are held";
  return true;
}

}  // namespace hrp
