// SPDX-License-Identifier: BSD-3-Clause
// The physics core as an engine of the dynamics loop.
#pragma once

#include "common/node/dynamics_loop.h"
#include "servers/dynamics/disturbance.h"
#include "servers/dynamics/movable_objects.h"
#include "servers/dynamics/simulator.h"

namespace hrp {

class SimulatorEngine : public DynamicsEngine {
 public:
  SimulatorEngine(const RobotDescription& robot, const Scenario& scenario);
  void reset() override {
    simulator_.reset();
    objects_.reset();
  }
  std::string step(const ContactSet& contacts, const JointCommand& command) override;
  const State& state() const override { return simulator_.state(); }
  unsigned long long state_hash() const override {
    return objects_.empty() ? simulator_.state_hash() : objects_.calc_hash(simulator_.state_hash());
  }
  const Eigen::VectorXd& joint_efforts() const override { return simulator_.joint_efforts(); }
  const ContactForces& contact_forces() const override {
    return objects_.empty() ? simulator_.contact_forces() : objects_.contact_forces();
  }
  const ObjectStates& objects() const override { return objects_.states(); }
  const SensorSample& sensors() const override { return simulator_.sensors(); }
  const std::vector<double>& foot_forces() const override { return simulator_.foot_forces(); }
  // Everything that decides the future: kept to go back to it. Pushes and hands depend on time and state alone.
  const Simulator& simulator() const { return simulator_; }
  const MovableObjects& movable_objects() const { return objects_; }
  void restore(const Simulator& kept, const MovableObjects& objects) {
    simulator_ = kept;
    objects_ = objects;
  }
  // Step 0 at this state. False when it does not fit the robot.
  [[nodiscard]] bool reset_to(const State& state) {
    objects_.reset();
    return simulator_.reset(state);
  }

 private:
  std::string describe(StepStatus status, const JointCommand& command) const;
  std::string describe_blow_up(const JointCommand& command) const;

  Scenario scenario_;
  Simulator simulator_;
  MovableObjects objects_;
  Pushes pushes_;
};

// For DynamicsLoop.
std::unique_ptr<DynamicsEngine> make_simulator_engine(const RobotDescription& robot, const Scenario& scenario);

}  // namespace hrp
