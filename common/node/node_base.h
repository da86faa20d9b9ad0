// SPDX-License-Identifier: BSD-3-Clause
// What all servers have in common: status reports, the end of the run, and faults that are said instead of thrown
// through a bus's thread.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/messages/pubsub.h"
#include "common/node/node.h"
#include "common/node/run_token.h"
#include "hrp_idl/scheduling.h"

namespace hrp {

class NodeBase : public Node {
 public:
  using Clock = std::chrono::steady_clock;

  // follows_run: ends when the scheduler says that the run has ended (everybody but the scheduler).
  explicit NodeBase(const NodeContext& context, bool follows_run = true);
  void make_endpoints() override;
  void drop_endpoints() override;
  void on_idle(Clock::time_point now) final;
  NodeOutcome outcome() const override { return outcome_; }
  void request_stop() override { finish(); }
  std::string failure() const override { return failure_; }
  bool has_told_failure() const override { return run_status_.phase() == msg::RUN_FAILED; }
  std::string find_missing() const override { return status_.waiting_for(); }

 protected:
  // Work of on_idle(); what it throws becomes a fault.
  virtual void handle_idle(Clock::time_point now) { (void)now; }
  // Asked at the end of the run until true: nothing that belongs to the run is still on its way to this node.
  virtual bool is_drained() { return true; }
  // The run has ended (RUN_FINISHED or RUN_FAILED) and is_drained(): close what is open. May call fail().
  virtual void handle_run_end() {}

  // Called once, before this node says its fault.
  virtual void handle_fault() {}

  // Subscribes reliably when the node is run, so not before it is constructed; what `on_message` throws becomes a
  // fault, and so does a sample that is no Message.
  template <typename Message, typename OnMessage>
  void listen(const TopicSpec& topic, OnMessage on_message) {
    subscriptions_.push_back([this, topic, on_message = std::move(on_message)] {
      return subscribe<Message>(
          bus(), topic, Delivery::kReliable,
          [this, on_message](const Message& message, Bytes sample) {
            if (!is_active()) return;
            if constexpr (std::is_invocable_v<OnMessage, const Message&, Bytes>) {
              guard([&] { on_message(message, sample); });
            } else {
              guard([&] { on_message(message); });
            }
          },
          [this, name = topic.name](const DecodeError& error) {
            if (is_active()) handle_decode_error(name, error.what());
          });
    });
  }
  virtual void handle_decode_error(const std::string& topic, const std::string& reason) { fail(topic + ": " + reason); }
  // `message` was signed with the run's token, or the run has none. Else it is ignored, and that is said once a topic.
  template <typename Message>
  bool is_authorized(const TopicSpec& topic, const Message& message) {
    if (is_signed(context_.token, topic.type_name, message)) return true;
    say_unauthorized(topic.name);
    return false;
  }
  void say_unauthorized(const std::string& topic);

  // Progress report; sent when something in it has changed.
  void report(unsigned long long epoch, unsigned long long step, const std::string& waiting_for = "");
  void set_phase(msg::ServerPhase phase);
  void set_foot_forces(const std::vector<double>& forces) { status_.foot_forces() = forces; }
  void set_file(const std::string& path) { status_.file(path); }
  // Sends the status as it stands.
  void send_status();
  // Says something that people should know and that stops nothing.
  void say(const std::string& text);
  // Says SERVER_FAULT with `reason`; the node ends when the scheduler has ended the run, or soon without one.
  void fail(const std::string& reason);
  // Ends this node without a fault and says SERVER_STOPPED.
  void finish();

  Bus& bus() { return *context_.bus; }
  const NodeContext& context() const { return context_; }
  bool is_active() const { return outcome_ == NodeOutcome::kRunning && failure_.empty(); }
  const msg::ServerStatus& status() const { return status_; }
  // As last heard from the scheduler.
  const msg::RunStatus& run_status() const { return run_status_; }
  // What `work` throws becomes a fault.
  void guard(const std::function<void()>& work);

 private:
  void take_run_status(const msg::RunStatus& status);

  NodeContext context_;
  Publisher<msg::ServerStatus> status_publisher_;
  msg::ServerStatus status_;
  msg::RunStatus run_status_;
  std::vector<std::function<std::unique_ptr<Reader>()>> subscriptions_;  // not made yet
  std::vector<std::unique_ptr<Reader>> readers_;
  NodeOutcome outcome_ = NodeOutcome::kRunning;
  std::string failure_;
  std::set<std::string> unauthorized_;  // topics on which somebody without the token spoke
  bool ending_ = false;                 // finish() was called, and waits for is_drained()
  bool fault_timed_ = false;
  Clock::time_point fault_end_;
  Clock::time_point last_report_;
};

}  // namespace hrp
