// SPDX-License-Identifier: BSD-3-Clause
// One run of a scenario in this process, without bus and log, many times faster than real time: the same model, contact
// finder, physics and controller as in the server set, called in the same order.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/node/live_pushes.h"
#include "controller/client.h"
#include "controller/play.h"
#include "servers/collision_checker/collision_world.h"
#include "servers/dynamics/engine.h"

namespace hrp {

// What happened. The robot has fallen when the server set says so (common/robot/fall_watch.h).
struct TrialResult {
  bool fallen = false;
  double fall_time = 0.0;                 // [s]
  double duration = 0.0;                  // [s] that were simulated
  double largest_lean = 0.0;              // [rad] of the base against the vertical
  Vector3d travelled = Vector3d::Zero();  // [m] of the base
  double turned = 0.0;                    // [rad] heading of the base
  std::vector<int> landings;              // by foot: how often it came down after it had been in the air for 0.1 s
  std::string fault;                      // of the simulator; empty when all went well
};

// What decides the future of a run: physics with all memories, the command that acts, the controller's memory.
struct TrialState {
  Simulator simulator;
  OtherBodies others;
  std::vector<std::shared_ptr<const Controller>> controllers;  // one a robot; none: it cannot be copied
  JointCommand command;
  LivePushes pushes;
  long step = 0;
};

class Trial {
 public:
  // With the scenario's controller, or another one; its other robots have those of their own scenarios. Throws
  // InputError.
  explicit Trial(const Scenario& scenario, const ControllerMaker& make_controller = make_scenario_controller);
  // Stands between dynamics and the controller: what it changes is what the controller sees.
  std::function<void(SensorData*)> tamper;
  // As the server set does; what is reported of the run is what was until the fall.
  bool go_on_after_fall = false;
  // Pushes a link of the first robot, or a body of others as Mover::name_body() has it, from the next step on, until
  // `steps` are over or the link is pushed again; 0 lets go. p_LQ [m] in link axes, force_W [N]. Throws InputError for
  // what cannot be.
  void push(const std::string& link, const Vector3d& p_LQ, const Vector3d& force_W, uint64_t steps);
  // One physics step; false when it failed.
  bool step();
  // Steps until the scenario's duration, a fault or, by default, a fall. on_step may be empty.
  TrialResult run(const std::function<void(const Trial&)>& on_step = nullptr);

  // Step 0 again, at the scenario's initial pose or at `state`; false when that does not fit the robot.
  void reset();
  [[nodiscard]] bool reset_to(const State& state);
  // A run that is restored goes on with the bits that it went on with before.
  TrialState save() const;
  void restore(const TrialState& kept);

  // What touches in the state now. The result lives until the next step.
  const ContactSet& calc_contacts() { return world_.calc_contacts(engine_->state(), engine_->objects()); }
  long step_number() const { return step_; }
  // Why step() was false; empty before.
  const std::string& fault() const { return fault_; }
  // As the controller is told; does not change.
  const Robot& controlled() const { return drivers_[0].robot; }
  double time() const { return static_cast<double>(step_) * scenario_.time_step; }
  const DynamicsEngine& engine() const { return *engine_; }
  const JointCommand& command() const { return command_; }
  const RobotDescription& robot() const { return robot_; }
  const Scenario& scenario() const { return scenario_; }

 private:
  struct Driver {
    Robot robot;
    std::unique_ptr<Controller> controller;
  };
  SensorData make_sensors(const SensorSample& sample) const;
  void start_controllers();
  void ask_controllers();

  RobotDescription robot_;
  Scenario scenario_;  // as given, with the loops of the robot's description
  CollisionWorld world_;
  std::unique_ptr<SimulatorEngine> engine_;
  std::vector<Driver> drivers_;  // one a robot, the first one before the scenario's others
  JointCommand command_;
  LivePushes pushes_;
  long step_ = 0;
  std::string fault_;
};

}  // namespace hrp
