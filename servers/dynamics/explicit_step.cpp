// SPDX-License-Identifier: BSD-3-Clause
// Explicit integrators, for comparison and for smooth systems: semi-implicit Euler (forces now, positions by the new
// velocities) and the classical Runge-Kutta method of order four. Memories of the joint laws (lag, hysteresis, motors)
// move on once a step.
#include "common/multibody/kinematics.h"
#include "servers/dynamics/simulator_impl.h"

namespace hrp {
namespace {

constexpr int kMaxStageSolves = 4;

// Rate of the rotation vector theta of R = exp(theta) R_0 that turns at w (world axes), to the order that the method
// of order four needs: dexp^-1 (Munthe-Kaas).
Vector3d calc_rotation_rate(const Vector3d& theta, const Vector3d& w) {
  const Vector3d c = theta.cross(w);
  return w - 0.5 * c + theta.cross(c) / 12.0;
}

}  // namespace

StepStatus Simulator::Impl::calc_stage(const State& at, double fraction) {
  joints.start(at, reference, 0.0, fraction, dt);
  for (int solve = 1;; ++solve) {
    const StepStatus status = solve_once(at, true);
    if (status != StepStatus::kOk || solve == kMaxStageSolves) return status;
    if (!joints.resolve(at, vdot.data() + model.num_base())) return status;
  }
}

StepStatus Simulator::Impl::advance_euler(const ContactSet& contacts) {
  spring.start(contacts, model, data, 0.0, dt);
  const StepStatus status = calc_stage(state, 0.0);
  if (status != StepStatus::kOk) return status;
  report.start(contacts);
  spring.finish(data, &report);
  finish_joints();
  integrate(nullptr);
  return StepStatus::kOk;
}

StepStatus Simulator::Impl::advance_runge_kutta(const ContactSet& contacts) {
  constexpr double kNodes[4] = {0.0, 0.5, 0.5, 1.0}, kWeights[4] = {1.0, 2.0, 2.0, 1.0};
  spring.start(contacts, model, data, 0.0, dt);
  get_generalised_velocity(model, state, &v);
  stage_v[4].setZero();  // weighted sums: [4] of position rates, [5] of accelerations
  stage_v[5].setZero();
  stage = state;
  for (size_t i = 0; i < 4; ++i) {
    if (i > 0) {
      stage = state;
      v_free = kNodes[i] * stage_v[i - 1];
      integrate_positions(model, v_free, dt, &stage);
      v_end = v + kNodes[i] * dt * stage_a[i - 1];
      set_generalised_velocity(model, v_end, &stage);
      update_kinematics(model, stage, &data);
      spring.move(data);
    }
    const StepStatus status = calc_stage(stage, kNodes[i]);
    if (status != StepStatus::kOk) return status;
    get_generalised_velocity(model, stage, &stage_v[i]);
    if (i > 0 && model.floating()) {
      const Vector3d theta = kNodes[i] * dt * stage_v[i - 1].head<3>();
      stage_v[i].head<3>() = calc_rotation_rate(theta, stage_v[i].head<3>());
    }
    stage_a[i] = vdot;
    stage_v[4] += kWeights[i] / 6.0 * stage_v[i];
    stage_v[5] += kWeights[i] / 6.0 * vdot;
  }
  update_kinematics(model, state, &data);  // contact parts and anchors as at the start of the step
  spring.move(data);
  report.start(contacts);
  spring.finish(data, &report);
  vdot = stage_v[5];
  finish_joints();
  next = state;
  integrate_positions(model, stage_v[4], dt, &next);
  stop_reversed_joints();
  set_generalised_velocity(model, v_end, &next);
  joints.put_perfect_positions(&next.q);
  return StepStatus::kOk;
}

// A joint with dry friction that turned round within the step has stood still in between.
void Simulator::Impl::stop_reversed_joints() {
  for (int i = 0; i < model.num_joints(); ++i) {
    double& qd = v_end[model.num_base() + i];
    const JointLaws& laws = joints.laws()[static_cast<size_t>(i)];
    if (laws.has_friction() && !laws.bends && qd * state.qd[i] < 0.0) qd = 0.0;
  }
}

}  // namespace hrp
