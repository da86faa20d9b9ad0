// SPDX-License-Identifier: BSD-3-Clause
// What a Simulator holds. Private to the folder.
#pragma once

#include "common/multibody/forward_dynamics.h"
#include "common/multibody/loops.h"
#include "servers/dynamics/impulse_contact.h"
#include "servers/dynamics/joint_system.h"
#include "servers/dynamics/link_effects.h"
#include "servers/dynamics/sensors.h"
#include "servers/dynamics/simulator.h"
#include "servers/dynamics/spring_contact.h"
#include "servers/dynamics/wrench_contact.h"

namespace hrp {

enum class Integrator { kImplicit, kSemiImplicitEuler, kRungeKutta4 };

struct Simulator::Impl {
  Impl(const RobotDescription& robot, const Scenario& scenario, TreeSpec tree, const std::vector<JointLaws>& laws,
       std::vector<SteadyForce> forces);

  void reset(const State& start);

  // The stages of a step, in this order.
  StepStatus check_inputs(const ContactSet& contacts, const JointCommand& command, const ExternalWrenches& pushes);
  StepStatus advance(const ContactSet& contacts);  // fills next, vdot, efforts, report
  StepStatus check_result();
  void accept();

  // implicit_step.cpp
  StepStatus advance_implicit(const ContactSet& contacts);
  StepStatus advance_impulse(const ContactSet& contacts);
  StepStatus solve_regimes();
  bool resolve_contacts() { return by_pair ? wrench.resolve(data) : spring.resolve(data); }
  bool hold_contacts(bool all) { return by_pair ? wrench.hold(data) : spring.freeze_violators(data, all); }
  StepStatus solve_impulses(const ContactSet& contacts);
  StepStatus solve_once(const State& at, bool with_contact);
  StepStatus solve_again();  // after solve_once() of the same state, when only contacts have changed since
  void mark_contacts(const ContactSet& contacts);
  void start_wrenches();
  void add_contacts();
  void finish_joints();
  void integrate(const Eigen::VectorXd* correction);

  // explicit_step.cpp
  StepStatus advance_euler(const ContactSet& contacts);
  StepStatus advance_runge_kutta(const ContactSet& contacts);
  StepStatus calc_stage(const State& at, double fraction);
  void stop_reversed_joints();

  StepStatus fail(StepStatus status, const std::string& text);
  StepStatus convert(Status status);
  void start_pushes();  // steady forces
  void check_loops() const;
  Status solve_loops(const State& at, const ImplicitTerms& implicit);
  void update_foot_forces();
  void update_sensors();
  void update_encoders();
  bool sensors_due() const;

  Scenario scenario;
  Model model;
  Data data;  // between steps: kinematics of `state`
  State start, state, next, stage;
  Integrator integrator = Integrator::kImplicit;
  bool impulse = false, by_pair = false;  // contact.model: impulse, wrench
  double dt = 0.001;
  long step = 0;

  Reference reference;
  JointSystem joints;
  SpringContact spring;
  ImpulseContact rigid;
  WrenchContact wrench;
  ContactReport report;
  Sensors sensors;

  std::vector<SteadyForce> steady_forces;
  Loops loops;                  // closed chains; no rows without
  Eigen::VectorXd loop_forces;  // J^T lambda
  LinkWrenches wrenches, push_wrenches;
  LinkImpedances impedances;
  std::vector<char> loaded;  // by link: contacts act on it, or on what it carries
  Eigen::VectorXd effort, inertia_extra, vdot, v, v_end, v_free;
  Eigen::VectorXd joint_efforts, servo_efforts;
  std::vector<Eigen::VectorXd> stage_v, stage_a;  // Runge-Kutta
  EncoderTruth encoders;
  std::vector<int> foot_of_link;  // index of the foot that a link belongs to, -1
  std::vector<double> foot_forces;
  std::string fault;
  int solves = 0;
};

}  // namespace hrp
