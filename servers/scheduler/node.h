// SPDX-License-Identifier: BSD-3-Clause
// The scheduler on a bus: reports in, grants and run status out.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "common/node/live_pushes.h"
#include "common/node/node_base.h"
#include "common/node/ros_services.h"
#include "hrp_idl/model.h"
#include "hrp_idl/scheduling.h"
#include "servers/scheduler/step_scheduler.h"

namespace hrp {

class SchedulerNode : public NodeBase {
 public:
  // duration_override: [s] of simulated time, < 0 = as the scenario says.
  // ros_services: whoever reaches the domain may pause, step and reset the run (ros_services.h).
  SchedulerNode(const NodeContext& context, const SchedulerOptions& options, double duration_override,
                bool ros_services = false);
  void make_endpoints() override;
  void drop_endpoints() override;
  std::chrono::milliseconds idle_period() const override { return std::chrono::milliseconds(2); }
  NodeOutcome outcome() const override;
  std::string failure() const override { return scheduler_.failure(); }
  bool has_told_failure() const override { return is_everybody_gone(); }
  std::string find_missing() const override { return scheduler_.late(); }
  // A clean end of the whole run.
  void request_stop() override;

 protected:
  void handle_idle(Clock::time_point now) override;
  void handle_decode_error(const std::string& topic, const std::string& reason) override;

 private:
  // Empty reason: after the steps that were granted.
  void request_stop(const std::string& reason);
  void attempt(const std::function<void()>& work);
  void look(Clock::time_point now);
  void take_description(const msg::RobotDescription& message);
  void take_refusal(const msg::ModelRefused& message);
  void take_status(const msg::ServerStatus& message);
  void take_control(const msg::RunControl& message);
  // Why not; empty when it is done.
  std::string follow(const msg::RunControl& message);
  std::string push(const msg::Push& push);
  SteerResult steer(msg::RunRequest request);
  void answer(const std::string& refused);
  void answer_stranger(const std::string& refused);
  void update();
  void update_status(Clock::time_point now);
  void publish_status(Clock::time_point now);
  double calc_real_time_factor(Clock::time_point now);
  bool has_ended() const;
  bool is_everybody_gone() const;

  StepScheduler scheduler_;
  UsedNonces used_nonces_;
  double duration_override_ = -1.0;
  Publisher<msg::StepGrant> grant_publisher_;
  Publisher<msg::RunStatus> status_publisher_;
  Grant granted_;
  TreeSpec tree_;  // of the first robot; without links before it is known
  std::vector<Mover> movers_;
  PushQueue pushes_;
  msg::RunStatus status_;
  Clock::time_point last_status_;
  std::deque<std::pair<Clock::time_point, uint64_t>> progress_;  // of the last second
  uint64_t progress_epoch_ = 0;
  std::map<std::string, bool> alive_;  // by role
  bool ended_ = false;
  Clock::time_point end_time_;
  bool gone_ = false;
  bool offers_ros_services_;
  std::unique_ptr<RosServices> ros_services_;
};

}  // namespace hrp
