// SPDX-License-Identifier: BSD-3-Clause
// The physics core as an engine of the dynamics loop.
#pragma once

#include "common/node/dynamics_loop.h"
#include "common/robot/pushes.h"
#include "servers/dynamics/other_bodies.h"
#include "servers/dynamics/simulator.h"

namespace hrp {

class SimulatorEngine : public DynamicsEngine {
 public:
  SimulatorEngine(const RobotDescription& robot, const Scenario& scenario);
  void reset() override {
    simulator_.reset();
    others_.reset();
    let_go();
  }
  std::string step(const ContactSet& contacts, const JointCommand& command) override;
  const State& state() const override { return simulator_.state(); }
  unsigned long long state_hash() const override {
    return others_.empty() ? simulator_.state_hash() : others_.calc_hash(simulator_.state_hash());
  }
  const Eigen::VectorXd& joint_efforts() const override { return simulator_.joint_efforts(); }
  const ContactForces& contact_forces() const override {
    return others_.empty() ? simulator_.contact_forces() : others_.contact_forces();
  }
  const ObjectStates& objects() const override { return others_.states(); }
  size_t num_other_robots() const override { return others_.num_robots(); }
  void command_other(size_t k, const JointCommand& command) override { others_.command(k, command); }
  const SensorSample& other_sensors(size_t k) const override { return others_.robot(k).sensors(); }
  const Eigen::VectorXd& other_efforts(size_t k) const override { return others_.robot(k).joint_efforts(); }
  const SensorSample& sensors() const override { return simulator_.sensors(); }
  const std::vector<double>& foot_forces() const override { return simulator_.foot_forces(); }
  bool push(const PushForces& forces) override {
    pushes_.set_live(others_.push(forces));
    return true;
  }
  const PushForces& pushes() const override { return acting_; }
  // Everything that decides the future: kept to go back to it. Pushes and hands depend on time and state alone.
  const Simulator& simulator() const { return simulator_; }
  const OtherBodies& other_bodies() const { return others_; }
  void restore(const Simulator& kept, const OtherBodies& others) {
    simulator_ = kept;
    others_ = others;
    let_go();
  }
  // Step 0 at this state. False when it does not fit the robot.
  [[nodiscard]] bool reset_to(const State& state) {
    others_.reset();
    let_go();
    return simulator_.reset(state);
  }

 private:
  void let_go() {
    pushes_.let_go();
    others_.let_go();
    acting_.clear();
  }
  std::string describe(StepStatus status, const JointCommand& command) const;
  std::string describe_blow_up(const JointCommand& command) const;

  Scenario scenario_;
  Simulator simulator_;
  OtherBodies others_;
  Pushes pushes_;
  PushForces acting_;  // over the last step, on the robot and all others
};

// For DynamicsLoop.
std::unique_ptr<DynamicsEngine> make_simulator_engine(const RobotDescription& robot, const Scenario& scenario);

}  // namespace hrp
