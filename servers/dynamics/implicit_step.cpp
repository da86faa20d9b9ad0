// SPDX-License-Identifier: BSD-3-Clause
// The linearly implicit step. Every law is affine in the velocities at the end of the step; positions there are
// q + dt v'. With effort = a - b v' and contact force F0 - Z (v' - v) / dt:
//
//   (M + dt diag(b) + sum J^T Z J) vdot = a - b v - h + J^T F0,   v' = v + dt vdot
//
// one articulated-body pass. Regimes (limits, friction, gaps, open and sliding contacts) are settled by repeating it.
#include <algorithm>

#include "common/multibody/kinematics.h"
#include "servers/dynamics/simulator_impl.h"

namespace hrp {
namespace {

// Most steps take one or two. The last answer is taken as it is.
constexpr int kMaxSolves = 10;
constexpr int kMaxImpulseRounds = 6;

}  // namespace

void Simulator::Impl::start_wrenches() {
  std::copy(push_wrenches.begin(), push_wrenches.end(), wrenches.begin());
  impedances.clear();
}

void Simulator::Impl::add_contacts() {
  if (by_pair) {
    wrench.add(data, &wrenches, &impedances);
  } else {
    spring.add(data, &wrenches, &impedances);
  }
}

StepStatus Simulator::Impl::solve_once(const State& at, bool with_contact) {
  joints.linearise(at, &effort, &inertia_extra);
  start_wrenches();
  if (with_contact) add_contacts();
  const ImplicitTerms implicit{&inertia_extra, &impedances};
  if (loops.rows() > 0) return convert(solve_loops(at, implicit));
  return convert(calc_forward_dynamics(model, effort, &wrenches, implicit, &data, &vdot));
}

StepStatus Simulator::Impl::solve_again() {
  if (loops.rows() > 0) return solve_once(state, true);  // the loops' forces are in the efforts
  start_wrenches();
  add_contacts();
  const ImplicitTerms implicit{&inertia_extra, &impedances};
  return convert(recalc_forward_dynamics(model, loaded, effort, &wrenches, implicit, &data, &vdot));
}

void Simulator::Impl::mark_contacts(const ContactSet& contacts) {
  std::fill(loaded.begin(), loaded.end(), 0);
  for (const ContactPair& pair : contacts) {
    for (const int body : {pair.body_a, pair.body_b}) {
      if (body >= 0) mark_path(model, body, &loaded);
    }
  }
}

// The forces that keep chains closed, then once more with them as efforts and a wrench on the base, so that contacts
// and sensors find the accelerations of the closed chain in `data`.
Status Simulator::Impl::solve_loops(const State& at, const ImplicitTerms& implicit) {
  const Status status = loops.calc_forward_dynamics(model, at, effort, &wrenches, implicit, &data, &vdot);
  if (status != Status::kOk) return status;
  loop_forces.noalias() = loops.jacobian().transpose() * loops.multipliers();
  if (model.floating()) wrenches[0] += loop_forces.head<6>();
  effort += loop_forces.tail(model.num_joints());
  return calc_forward_dynamics(model, effort, &wrenches, implicit, &data, &vdot);
}

StepStatus Simulator::Impl::solve_regimes() {
  const double* qdd = vdot.data() + model.num_base();
  bool joints_changed = true;
  for (solves = 1;; ++solves) {
    const StepStatus status = joints_changed ? solve_once(state, true) : solve_again();
    if (status != StepStatus::kOk) return status;
    if (solves == kMaxSolves) break;
    joints_changed = joints.resolve(state, qdd);
    if (!resolve_contacts() && !joints_changed) break;
  }
  // Rarely regimes go round in circles, mostly while a foot lands on an edge. The third time everything is held.
  for (int round = 0; round < 3 && hold_contacts(round == 2); ++round) {
    ++solves;
    const StepStatus status = solve_again();
    if (status != StepStatus::kOk) return status;
  }
  return StepStatus::kOk;
}

void Simulator::Impl::finish_joints() {
  get_generalised_velocity(model, state, &v);
  v_end = v + dt * vdot;
  next.qd = v_end.tail(model.num_joints());
  joints.finish(state, vdot.data() + model.num_base(), &next.qd, &joint_efforts, &servo_efforts);
  v_end.tail(model.num_joints()) = next.qd;
}

void Simulator::Impl::integrate(const Eigen::VectorXd* correction) {
  next = state;
  if (correction) v_free = v_end + *correction;
  integrate_positions(model, correction ? v_free : v_end, dt, &next);
  set_generalised_velocity(model, v_end, &next);
  joints.put_perfect_positions(&next.q);
}

StepStatus Simulator::Impl::advance_implicit(const ContactSet& contacts) {
  joints.start(state, reference, dt, 1.0, dt);
  if (by_pair) {
    wrench.start(contacts, model, data, dt);
  } else {
    spring.start(contacts, model, data, dt, dt);
  }
  mark_contacts(contacts);
  const StepStatus status = solve_regimes();
  if (status != StepStatus::kOk) return status;
  report.start(contacts);
  if (by_pair) {
    wrench.finish(data, &report);
  } else {
    spring.finish(data, &report);
  }
  finish_joints();
  integrate(nullptr);
  return StepStatus::kOk;
}

// Free motion, impulses, then once more with the impulses as forces, so that joint regimes see them.
StepStatus Simulator::Impl::solve_impulses(const ContactSet& contacts) {
  const double* qdd = vdot.data() + model.num_base();
  for (solves = 1;; ++solves) {
    StepStatus status = solve_once(state, false);
    if (status != StepStatus::kOk) return status;
    get_generalised_velocity(model, state, &v);
    v_free = v + dt * vdot;
    status = convert(rigid.solve(contacts, model, inertia_extra, v, v_free, loops.jacobian(), &data));
    if (status != StepStatus::kOk) return status;
    rigid.add(data, dt, &wrenches);
    const ImplicitTerms implicit{&inertia_extra, nullptr};
    // With loops: what they answer to the impulses, beside what solve_once() has put into effort and wrenches.
    status = convert(loops.rows() > 0 ? solve_loops(state, implicit)
                                      : calc_forward_dynamics(model, effort, &wrenches, implicit, &data, &vdot));
    if (status != StepStatus::kOk || solves == kMaxImpulseRounds || !joints.resolve(state, qdd)) return status;
  }
}

StepStatus Simulator::Impl::advance_impulse(const ContactSet& contacts) {
  joints.start(state, reference, dt, 1.0, dt);
  const StepStatus status = solve_impulses(contacts);
  if (status != StepStatus::kOk) return status;
  finish_joints();
  report.start(contacts);
  rigid.report(dt, v_end, &report);
  integrate(&rigid.correction_velocity(dt));
  return StepStatus::kOk;
}

}  // namespace hrp
