// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/node_base.h"

#include <unistd.h>

#include <exception>

#include "common/messages/topics.h"

namespace hrp {
namespace {

// A server at fault waits this long for the scheduler to end the run, so that the reason is heard before it leaves.
constexpr auto kFaultPatience = std::chrono::milliseconds(500);
// Reports are repeated this often while nothing changes: a sign of life.
constexpr auto kHeartbeat = std::chrono::milliseconds(250);

}  // namespace

NodeBase::NodeBase(const NodeContext& context, bool follows_run)
    : context_(context), status_publisher_(*context.bus, topics::kServerStatus) {
  status_.server(context.role);
  status_.program(context.program);
  status_.vendor(context.bus->vendor());
  status_.process_id(static_cast<int32_t>(getpid()));
  status_.phase(msg::SERVER_STARTING);
  status_.epoch(0);
  status_.step(0);
  if (follows_run) {
    subscriptions_.push_back([this] {
      return subscribe<msg::RunStatus>(bus(), topics::kRunStatus, Delivery::kReliable,
                                       [this](const msg::RunStatus& status) { take_run_status(status); });
    });
  }
  send_status();
}

void NodeBase::make_endpoints() {
  for (const auto& subscribe_now : subscriptions_) readers_.push_back(subscribe_now());
  subscriptions_.clear();
}

void NodeBase::drop_endpoints() {
  subscriptions_.clear();
  readers_.clear();
}

void NodeBase::on_idle(Clock::time_point now) {
  if (is_active()) guard([&] { handle_idle(now); });
  if (is_active() && now - last_report_ > kHeartbeat) send_status();
  if (is_active() && ending_) finish();
  if (outcome_ != NodeOutcome::kRunning || failure_.empty()) return;
  if (!fault_timed_) {
    fault_timed_ = true;
    fault_end_ = now + kFaultPatience;
  } else if (now > fault_end_) {
    outcome_ = NodeOutcome::kFailed;
  }
}

void NodeBase::report(unsigned long long epoch, unsigned long long step, const std::string& waiting_for) {
  if (status_.epoch() == epoch && status_.step() == step && status_.waiting_for() == waiting_for) return;
  status_.epoch(epoch);
  status_.step(step);
  status_.waiting_for(waiting_for);
  send_status();
}

void NodeBase::set_phase(msg::ServerPhase phase) {
  if (status_.phase() == phase) return;
  status_.phase(phase);
  send_status();
}

void NodeBase::send_status() {
  last_report_ = Clock::now();
  if (status_.phase() == msg::SERVER_FAULT) sign(context_.token, topics::kServerStatus.type_name, &status_);
  status_publisher_.publish(status_);
}

void NodeBase::say(const std::string& text) {
  status_.message(text);
  send_status();
}

void NodeBase::fail(const std::string& reason) {
  if (!is_active()) return;
  failure_ = reason.empty() ? "failed without a reason" : reason;
  handle_fault();
  status_.message(failure_);
  set_phase(msg::SERVER_FAULT);
}

void NodeBase::finish() {
  if (outcome_ != NodeOutcome::kRunning) return;
  ending_ = true;
  if (failure_.empty() && !is_drained()) return;  // on_idle() asks again
  if (failure_.empty()) guard([this] { handle_run_end(); });
  if (failure_.empty()) {
    outcome_ = NodeOutcome::kFinished;
    set_phase(msg::SERVER_STOPPED);
  } else {
    outcome_ = NodeOutcome::kFailed;
  }
}

void NodeBase::guard(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

void NodeBase::take_run_status(const msg::RunStatus& status) {
  if (is_over(status) && !is_authorized(topics::kRunStatus, status)) return;
  if (!may_follow(run_status_, status)) return;
  run_status_ = status;
  if (is_over(status)) finish();
}

void NodeBase::say_unauthorized(const std::string& topic) {
  if (!unauthorized_.insert(topic).second) return;
  say("ignored a message on " + topic + " that is not signed with the token of this run");
}

}  // namespace hrp
