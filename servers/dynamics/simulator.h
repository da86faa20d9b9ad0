// SPDX-License-Identifier: BSD-3-Clause
// The physics of one run: state in, contacts and commands in, next state out. No bus, no messages, no clock.
//
//   Simulator simulator(robot, scenario);           // throws InputError: what cannot be simulated, and why
//   while (...) status = simulator.step(contacts_of(simulator.state()), command);
//
// A step from k to k + 1 uses the contact set found in state k and the command given for k. It allocates nothing and
// throws nothing. Equal inputs give equal bits. Laws and their equations: docs/physics.md.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/multibody/state.h"
#include "common/robot/external_wrench.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"
#include "common/robot/signals.h"

namespace hrp {

struct Data;  // common/multibody/model.h

enum class [[nodiscard]] StepStatus{
    kOk,
    kBadCommand,      // wrong number of joints, NaN or infinity
    kBadContact,      // unknown body, NaN, normal that is no unit vector, more points than the simulator has room for
    kBadForce,        // external wrench on an unknown link, NaN
    kNonFiniteState,  // the next state would not be finite: the state stays what it was
    kSingular,        // an articulated inertia is not positive: massless subtree, negative mass
};

const char* get_step_status_text(StepStatus status);

class Simulator {
 public:
  // Throws InputError naming the key, joint or link that cannot be simulated.
  Simulator(const RobotDescription& robot, const Scenario& scenario);
  ~Simulator();
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;
  // A copy goes on with the same bits: it has the state and everything that remembers.
  Simulator(const Simulator&);
  Simulator& operator=(const Simulator&);

  // Step 0 again, at the scenario's initial pose or at `state`. Everything with a memory (filters, delays, anchors of
  // sticking contacts, motors behind elastic gears) starts afresh. Returns false when `state` does not fit the robot.
  void reset();
  [[nodiscard]] bool reset(const State& state);

  // One physics step. On anything but kOk the state is what it was and fault_text() says what happened.
  StepStatus step(const ContactSet& contacts, const JointCommand& command, const ExternalWrenches& pushes = {});

  const State& state() const;
  const Data& kinematics() const;  // of state(): Data::kinematics holds
  long step_number() const;
  double time() const;       // [s] = step_number() x time step
  double time_step() const;  // [s]
  // Of everything that decides the future: state(), memories of the laws, step number.
  unsigned long long state_hash() const;
  // Names what was wrong in the last step: joint, link, contact, value. Empty after kOk.
  const std::string& fault_text() const;

  // What acted over the last step; empty or zero at step 0.
  const ContactForces& contact_forces() const;
  const Eigen::VectorXd& joint_efforts() const;  // [N m or N] on the links: servo, friction, springs, stops
  const Eigen::VectorXd& servo_efforts() const;  // [N m or N] as the drive logs them
  // [N] vertical contact force on each foot of the scenario (with everything below its force sensor), their order.
  const std::vector<double>& foot_forces() const;
  // Readings in the state reached by the last step, with the sensor errors of the scenario.
  const SensorSample& sensors() const;

  // Passes of the articulated-body algorithm that the last implicit step took: more than one when regimes switched.
  int solves() const;

  const TreeSpec& tree() const;  // after effects that change masses or inertias

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Height of the base at which the lowest point of the robot's soles (of all shapes where it has none) touches the
// ground under it, with the scenario's initial attitude and joint positions. Meshes count as soles only. [m]
double calc_initial_height(const RobotDescription& robot, const Scenario& scenario);

// The state at step 0 as the scenario asks for it.
State make_initial_state(const RobotDescription& robot, const Scenario& scenario);

}  // namespace hrp
