// SPDX-License-Identifier: BSD-3-Clause
// Small stand-ins for servers on a memory bus, to test the step protocol without physics.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/memory/memory_bus.h"
#include "common/messages/convert_robot.h"
#include "common/messages/topics.h"
#include "common/node/dynamics_loop.h"
#include "common/node/runner.h"
#include "controller/node.h"
#include "servers/scheduler/node.h"
#include "tests/unit/chain.h"

namespace hrp::test {

inline RobotDescription make_two_joint_robot(const std::string& controller) {
  RobotDescription robot;
  robot.tree = make_chain("fake", {"joint0", "joint1"});
  robot.scenario_path = "fake.yaml";
  robot.scenario =
      "robot: fake.urdf\n"
      "servo: {default: {kp: 1, kd: 0}}\n"
      "steps: {time_step: 0.001, control_period: 0.005, duration: 0.3}\n" +
      controller;
  return robot;
}

// Follows its references at once: easy to predict.
class FakeEngine : public DynamicsEngine {
 public:
  explicit FakeEngine(const RobotDescription& robot) : n_(robot.tree.num_joints()) { reset(); }
  void reset() override {
    state_ = State{};
    state_.q.setZero(n_);
    state_.qd.setZero(n_);
    efforts_.setZero(n_);
    sensors_.q = sensors_.qd = sensors_.effort = efforts_;
  }
  std::string step(const ContactSet&, const JointCommand& command) override {
    pushed_ = acting_;
    state_.q = command.q;
    sensors_.q = command.q;
    return fault_at_q > 0.0 && command.q[0] > fault_at_q ? "joint 'joint0' flew away" : "";
  }
  const State& state() const override { return state_; }
  unsigned long long state_hash() const override { return calc_state_hash(state_); }
  const Eigen::VectorXd& joint_efforts() const override { return efforts_; }
  const ContactForces& contact_forces() const override { return forces_; }
  const SensorSample& sensors() const override { return sensors_; }
  const std::vector<double>& foot_forces() const override { return feet_; }
  bool push(const PushForces& forces) override {
    if (!takes_pushes) return DynamicsEngine::push(forces);
    acting_ = forces;
    return true;
  }
  const PushForces& pushes() const override { return pushed_; }
  double fault_at_q = 0.0;
  bool takes_pushes = true;

 private:
  int n_;
  State state_;
  Eigen::VectorXd efforts_;
  ContactForces forces_;
  SensorSample sensors_;
  std::vector<double> feet_;
  PushForces acting_, pushed_;
};

class FakeParser : public NodeBase {
 public:
  FakeParser(const NodeContext& context, const RobotDescription& robot)
      : NodeBase(context), publisher_(bus(), topics::kRobotDescription) {
    msg::RobotDescription message;
    to_message(robot, &message);
    publisher_.publish(message);
    set_phase(msg::SERVER_READY);
  }

 private:
  Publisher<msg::RobotDescription> publisher_;
};

class FakeCollisionChecker : public NodeBase {
 public:
  explicit FakeCollisionChecker(const NodeContext& context)
      : NodeBase(context), publisher_(bus(), topics::kContactSet) {
    listen<msg::RobotState>(topics::kRobotState, [this](const msg::RobotState& m) {
      msg::ContactSet answer;
      answer.header(m.header());
      publisher_.publish(answer);
    });
  }

 private:
  Publisher<msg::ContactSet> publisher_;
};

// Turns each sample into the answers that are sent for it: none, one, several, wrong ones.
using Answerer = std::function<std::vector<msg::JointCommands>(const msg::SensorData&)>;

class FakeController : public NodeBase {
 public:
  FakeController(const NodeContext& context, Answerer answerer)
      : NodeBase(context), answerer_(std::move(answerer)), publisher_(bus(), topics::kJointCommands) {
    listen<msg::SensorData>(topics::kSensorData, [this](const msg::SensorData& m) {
      for (const msg::JointCommands& answer : answerer_(m)) publisher_.publish(answer);
    });
  }

 private:
  Answerer answerer_;
  Publisher<msg::JointCommands> publisher_;
};

inline msg::JointCommands make_good_answer(const msg::SensorData& sensors) {
  msg::JointCommands answer;
  answer.header(sensors.header());
  answer.positions({sensors.header().time(), 0.5});
  return answer;
}

struct FakeRunResult {
  msg::RunStatus status;
  std::vector<msg::RobotState> states;  // as an inspector sees them, repeats left out
};

struct FakeRunOptions {
  std::string controller_section;
  Answerer answerer = [](const msg::SensorData& m) { return std::vector<msg::JointCommands>{make_good_answer(m)}; };
  double fault_at_q = 0.0;
  bool takes_pushes = true;
  std::function<void(const msg::RobotState&, Publisher<msg::RunControl>&)> on_state;
  std::string token;                                        // of the run
  std::function<std::shared_ptr<Bus>(MemoryBus&)> network;  // what the servers see in place of the bus
  std::function<std::shared_ptr<void>(Bus&)> join;          // makes somebody else's ends, kept as long as the bus
};

inline FakeRunResult run_fake_set(const FakeRunOptions& options) {
  MemoryBus bus;
  FakeRunResult result;
  const std::shared_ptr<void> joined = options.join ? options.join(bus) : nullptr;
  Publisher<msg::RunControl> control(bus, topics::kRunControl);
  const auto status_reader = subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable,
                                                       [&](const msg::RunStatus& m) { result.status = m; });
  const auto state_reader =
      subscribe<msg::RobotState>(bus, topics::kRobotState, Delivery::kReliable, [&](const msg::RobotState& m) {
        const auto is_same = [&](const msg::Header& h) {
          return h.epoch() == m.header().epoch() && h.step() == m.header().step();
        };
        if (!result.states.empty() && is_same(result.states.back().header())) return;
        result.states.push_back(m);
        if (options.on_state) options.on_state(m, control);
      });
  const std::shared_ptr<Bus> network = options.network ? options.network(bus) : nullptr;
  const auto context = [&](const char* role) {
    return NodeContext{network ? network.get() : &bus, role, "fake", options.token};
  };
  SchedulerOptions scheduling;
  scheduling.roles = {"dynamics"};
  SchedulerNode scheduler(context("scheduler"), scheduling, -1.0);
  DynamicsLoop dynamics(context("dynamics"), [&](const RobotDescription& robot, const Scenario&) {
    auto engine = std::make_unique<FakeEngine>(robot);
    engine->fault_at_q = options.fault_at_q;
    engine->takes_pushes = options.takes_pushes;
    return engine;
  });
  FakeCollisionChecker collision_checker(context("collision_checker"));
  FakeController controller(context("controller"), options.answerer);
  FakeParser parser(context("model_parser"), make_two_joint_robot(options.controller_section));
  run_in_process({&scheduler, &dynamics, &collision_checker, &controller, &parser}, bus, &scheduler);
  return result;
}

}  // namespace hrp::test
