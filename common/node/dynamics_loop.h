// SPDX-License-Identifier: BSD-3-Clause
// The loop of every dynamics server (ours, MuJoCo's, yours): an engine that steps, and the step protocol around it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/messages/convert.h"
#include "common/node/command_gate.h"
#include "common/node/live_pushes.h"
#include "common/node/lockstep.h"
#include "common/node/log_samples.h"
#include "common/node/node_base.h"
#include "common/node/ros_views.h"
#include "common/node/view_writer.h"
#include "common/robot/fall_watch.h"
#include "common/robot/movers.h"
#include "hrp_idl/model.h"

namespace hrp {

// An engine owns the state at step k and what acted over the step that ended there.
class DynamicsEngine {
 public:
  virtual ~DynamicsEngine() = default;
  virtual void reset() = 0;  // to step 0
  // From k to k + 1. Empty when all went well, else what went wrong, naming joint or contact.
  virtual std::string step(const ContactSet& contacts, const JointCommand& command) = 0;
  virtual const State& state() const = 0;
  virtual unsigned long long state_hash() const = 0;
  virtual const Eigen::VectorXd& joint_efforts() const = 0;  // [N m or N]
  virtual const ContactForces& contact_forces() const = 0;
  virtual const SensorSample& sensors() const = 0;
  // Of the scenario's objects, then of its other robots; empty where an engine has none.
  virtual const ObjectStates& objects() const {
    static const ObjectStates kNone;
    return kNone;
  }
  // Other robots of the scenario; engines that simulate none keep these as they are.
  virtual size_t num_other_robots() const { return 0; }
  // Command of other robot `k` (in the order of the scenario) from the next step on.
  virtual void command_other(size_t k, const JointCommand& command) { (void)k, (void)command; }
  virtual const SensorSample& other_sensors(size_t k) const { return (void)k, sensors(); }
  virtual const Eigen::VectorXd& other_efforts(size_t k) const { return (void)k, joint_efforts(); }  // [N m or N]
  // Live pushes that act in the next step, beside those of the scenario. False: this engine takes none.
  virtual bool push(const PushForces& forces) { return forces.empty(); }
  // From outside, over the step that ended here: of the scenario and live ones.
  virtual const PushForces& pushes() const {
    static const PushForces kNone;
    return kNone;
  }
  virtual const std::vector<double>& foot_forces() const = 0;  // [N] vertical, in the order of Scenario::feet
};

// Throws InputError when the scenario cannot be simulated.
using EngineFactory =
    std::function<std::unique_ptr<DynamicsEngine>(const RobotDescription& robot, const Scenario& scenario)>;

class DynamicsLoop : public NodeBase {
 public:
  // `ros_rate`: see RosViews.
  DynamicsLoop(const NodeContext& context, EngineFactory make_engine, double ros_rate = 0.0);
  void make_endpoints() override;
  void drop_endpoints() override;
  std::string find_missing() const override;

 protected:
  void handle_idle(Clock::time_point now) override;
  void handle_decode_error(const std::string& topic, const std::string& reason) override;
  void handle_run_end() override;
  void handle_fault() override { flush_gathered(); }

 private:
  void take_description(const msg::RobotDescription& message);
  void take_grant(const msg::StepGrant& grant);
  std::string find_wrong_grant(const msg::StepGrant& grant) const;
  void take_contacts(const msg::ContactSet& message, Bytes sample);
  void add_robots();
  void make_other_endpoints();
  // `robot`: 0 is the scenario's first one.
  void take_commands(size_t robot, const msg::JointCommands& message);
  void take_garbage(size_t robot, const std::string& reason);
  std::unique_ptr<DynamicsEngine> make_engine() const;
  void start_epoch(uint64_t epoch);
  void advance();
  bool can_step() const { return in_epoch_ && have_contacts_ && have_answers() && step_ < granted_; }
  bool have_answers() const;
  void command_others();
  void push();
  bool is_control_step() const { return step_ % static_cast<uint64_t>(scenario_.control_period) == 0; }
  bool check_contacts(const ContactSet& contacts);
  void publish_step();
  void publish_sensors();
  // What no step waits for.
  void flush_gathered();
  void watch_fall(size_t robot);
  void show_step();
  void repeat_last();
  void say_warning();
  msg::Header make_header() const;

  // What is sent to, and asked of, the controller of a robot.
  struct Controlled {
    Mover body;  // its name is "" of the first robot
    CommandGate gate;
    FallWatch fall_watch;
    Publisher<msg::SensorData> publisher;
    Publisher<msg::RobotEvent> events;
    std::unique_ptr<Reader> reader;  // of its commands; NodeBase has that of the first robot
    msg::SensorData message;
    std::string log_topic;  // of its sensor data
    Bytes last;             // in the publisher's buffer
  };
  const State& get_state(size_t robot) const {
    return find_robot_state(robot, engine_->state(), engine_->objects(), scenario_);
  }
  const SensorSample& get_sensors(size_t robot) const {
    return robot == 0 ? engine_->sensors() : engine_->other_sensors(robot - 1);
  }

  EngineFactory make_engine_;
  RobotDescription robot_;
  Scenario scenario_;
  BodyNames names_;
  std::vector<Mover> movers_;
  std::unique_ptr<DynamicsEngine> engine_;

  Publisher<msg::RobotState> state_publisher_;
  Publisher<msg::ContactForces> forces_publisher_;
  LogSamples log_samples_;
  RosViews ros_views_;
  double ros_rate_;
  ViewWriter view_;
  msg::RobotState state_message_;
  msg::ContactForces forces_message_;
  Bytes last_state_, last_forces_;  // in the publishers' buffers

  bool in_epoch_ = false;
  uint64_t epoch_ = 0;
  uint64_t step_ = 0;
  uint64_t granted_ = 0;   // through this step
  bool has_last_ = false;  // of this epoch: the scheduler has said which step is the last
  uint64_t last_step_ = 0;
  LivePushes pushes_;
  bool pushes_ignored_ = false;  // and said so
  bool have_contacts_ = false;
  ContactSet contacts_;
  std::vector<uint8_t> contacts_sample_;  // as it came; empty before the first of an epoch
  std::vector<Controlled> robots_;        // the first one from the beginning, others when the scenario is known
  std::vector<Eigen::VectorXd> other_efforts_;
  std::vector<RobotSample> ros_samples_;
  RepeatTimer repeat_timer_;
  uint64_t idle_epoch_ = 0;  // (epoch, step) at the last handle_idle(): silence is measured from there
  uint64_t idle_step_ = 0;
  bool ros_views_made_ = false;
  std::string warning_said_;
};

}  // namespace hrp
