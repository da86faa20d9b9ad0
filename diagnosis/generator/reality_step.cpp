// SPDX-License-Identifier: BSD-3-Clause
// Length of a step, the forces on the robot, and the step itself.
#include <algorithm>
#include <cmath>

#include "diagnosis/generator/reality_impl.h"

namespace hrp::cases {
namespace {

constexpr double kPostures = 0.05;  // [s] between those for which a step is found

}  // namespace

// Largest rate of M^-1 D (damping) or frequency of M^-1 K, by power iteration from a fixed start. `soles_lift`: with
// the bushes of soft soles. The ground holds a sole that is pressed flat on it; once an edge lifts, the sole alone
// moves against its bush, at 50000/s.
double Reality::Impl::find_rate(bool stiffness, bool soles_lift) {
  std::vector<double> x(static_cast<std::size_t>(m->nv), 1.0), y(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += 0.1 * static_cast<double>(i);
  double rate = 0;
  for (int iteration = 0; iteration < 60; ++iteration) {
    std::fill(y.begin(), y.end(), 0.0);
    for (int j = 0; j < count(); ++j) {
      const auto i = static_cast<std::size_t>(j);
      const double servo = stiffness ? joint(robot, j).kp : joint(robot, j).kd + joints[i].viscous;
      const auto motor = static_cast<std::size_t>(v_motor[i]), link = static_cast<std::size_t>(v_link[i]);
      y[motor] += servo * x[motor];
      if (!joints[i].elastic) continue;
      const double across = (stiffness ? joints[i].stiffness : joints[i].damping) * (x[motor] - x[link]);
      y[motor] += across;
      y[link] -= across;
    }
    for (const Bush& bush : bushes) {
      const auto first = static_cast<std::size_t>(bush.dof);
      for (std::size_t a = 0; soles_lift && a < 3; ++a)
        y[first + a] += (stiffness ? bush.k[a] : bush.c[a]) * x[first + a];
    }
    mj_solveM(m, d, x.data(), y.data(), 1);
    double norm = 0;
    for (double value : x) norm += value * value;
    rate = std::sqrt(norm);
    if (rate == 0) return 0;
    for (double& value : x) value /= rate;
  }
  return stiffness ? std::sqrt(rate) : rate;
}

// The longest stable step [s] at the present posture. Arms: Runge-Kutta 4 (stable to 2.8). Standing robots: the
// midpoint rule (to 2.0), because contact costs more than it.
double Reality::Impl::find_step(bool soles_lift) {
  mj_kinematics(m, d);
  mj_comPos(m, d);
  mj_crb(m, d);
  mj_factorM(m, d);
  const double limit = robot.floating ? 1.2 : 1.6;
  return std::min(
      {robot.floating ? 3e-4 : 2.5e-4, limit / find_rate(false, soles_lift), 1.0 / find_rate(true, soles_lift)});
}

// Wherever the commands lead: a joint about which the arm is stretched turns a tenth of the inertia it turned at the
// start, and the servo that was stable there hums at the frequency of the steps here.
void Reality::Impl::choose_step(double end, bool soles_lift) {
  reset();
  dt = find_step(soles_lift);
  for (double t = 0; t < end; t += kPostures) {
    for (int j = 0; j < count(); ++j) {
      const auto i = static_cast<std::size_t>(j);
      double c = 0, cd = 0;
      commands->find(j, t, c, cd);
      d->qpos[q_link[i]] = d->qpos[q_motor[i]] = c - joints[i].offset;
    }
    dt = std::min(dt, find_step(soles_lift));
  }
  if (dt < (soles_lift ? 2e-6 : 2e-5)) throw InsaneCase{"servo too stiff for the masses"};
}

double Reality::Impl::calc_servo_effort(int j, double t, const double* q, const double* v) const {
  const auto i = static_cast<std::size_t>(j);
  const JointPlan& servo = joint(robot, j);
  double c = 0, cd = 0;
  commands->find(j, t - joints[i].delay, c, cd);
  const double effort = servo.kp * (c - q[q_motor[i]] - joints[i].offset) + servo.kd * (cd - v[v_motor[i]]);
  return std::clamp(effort, -servo.limit, servo.limit);
}

void Reality::Impl::apply_joint(int j, double t, const std::vector<double>& states, std::vector<double>& rates) {
  const auto i = static_cast<std::size_t>(j), n = static_cast<std::size_t>(count());
  const JointReality& real = joints[i];
  const double qm = d->qpos[q_motor[i]], ql = d->qpos[q_link[i]], vm = d->qvel[v_motor[i]], vl = d->qvel[v_link[i]];
  const double asked = calc_servo_effort(j, t, d->qpos, d->qvel);
  const double driven = real.lag > 0 ? states[i] : asked;
  rates[i] = real.lag > 0 ? (asked - states[i]) / real.lag : 0;
  rates[n + i] = real.bouc_wen_stiffness > 0 ? calc_bouc_wen_rate(real, vm, states[n + i]) : 0;
  rates[2 * n + i] = real.heat_loss > 0 ? calc_heat_rate(real, driven, states[2 * n + i]) : 0;
  d->qfrc_applied[v_motor[i]] += calc_drive_torque(real, driven, vm, states[2 * n + i], t) +
                                 calc_motor_side_torque(real, qm, vm, states[n + i], t);
  const double link_side = calc_link_side_torque(real, ql, vl);
  d->qfrc_applied[v_link[i]] += link_side;
  beside[i] += link_side;
  if (real.elastic) {
    const double through = calc_transmission_torque(real, qm, ql, vm, vl);
    d->qfrc_applied[v_link[i]] += through;
    d->qfrc_applied[v_motor[i]] -= through;
  }
  if (real.coupled_to >= 0) {  // a cable between two joints: a spring on the sum of their turns from the start
    const auto o = static_cast<std::size_t>(real.coupled_to);
    const double turn = ql - joint(robot, j).start + d->qpos[q_link[o]] - joint(robot, real.coupled_to).start;
    d->qfrc_applied[v_link[i]] -= real.coupling * turn;
    d->qfrc_applied[v_link[o]] -= real.coupling * turn;
    beside[i] -= real.coupling * turn;
    beside[o] -= real.coupling * turn;
  }
}

void Reality::Impl::apply_forces(double t, const std::vector<double>& states, std::vector<double>& rates) {
  mju_zero(d->qfrc_applied, m->nv);
  mju_zero(d->xfrc_applied, 6 * m->nbody);
  beside.assign(static_cast<std::size_t>(count()), 0.0);
  for (int j = 0; j < count(); ++j) apply_joint(j, t, states, rates);
  for (const Bush& bush : bushes) {
    for (int a = 0; a < 3; ++a) {
      const double x = d->qpos[bush.qpos + a], v = d->qvel[bush.dof + a];
      double k = bush.k[a];
      if (a > 0 && bush.hardening_angle > 0) k *= 1 + (x / bush.hardening_angle) * (x / bush.hardening_angle);
      d->qfrc_applied[bush.dof + a] += -k * x - bush.c[a] * v;
    }
  }
  walk_forces->apply(m, d);
  for (const auto& [body, force] : forces) {
    for (std::size_t a = 0; a < 3; ++a) d->xfrc_applied[6 * body + static_cast<int>(a)] += force[a];
  }
  for (const Gust& gust : gusts) {
    const double force = gust.amplitude * std::sin(6.28318530717958647692 * gust.frequency * t);
    d->xfrc_applied[6 * gust.body] += force * std::cos(gust.direction);
    d->xfrc_applied[6 * gust.body + 1] += force * std::sin(gust.direction);
  }
  if (push_body >= 0 && t < 0) {
    for (std::size_t a = 0; a < 3; ++a) d->xfrc_applied[6 * push_body + static_cast<int>(a)] += push[a];
  }
}

void Reality::Impl::update_dry_friction(double t) {
  for (int j = 0; j < count(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    const double torque = calc_servo_effort(j, t, d->qpos, d->qvel);
    m->dof_frictionloss[v_motor[i]] = calc_dry_friction(joints[i], d->qpos[q_motor[i]], d->qvel[v_motor[i]], torque, t);
  }
}

// Explicit Runge-Kutta of order 4 (arms) or 2 (floating base) over position, velocity and the laws' own states; the
// level of dry friction is held over the step.
void Reality::Impl::step(double t, double h) {
  update_dry_friction(t);
  const int stages = robot.floating ? 2 : 4;
  const double node[4] = {0, 0.5, 0.5, 1}, weight4[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, weight2[2] = {0, 1};
  const double* weight = stages == 4 ? weight4 : weight2;
  const std::size_t nv = static_cast<std::size_t>(m->nv);
  const std::vector<double> q0(d->qpos, d->qpos + m->nq), v0(d->qvel, d->qvel + m->nv), z0 = z;
  std::vector<double> v_sum(nv, 0.0), a_sum(nv, 0.0), z_sum(z.size(), 0.0), v_k = v0, a_k(nv), z_k(z.size(), 0.0);
  for (int s = 0; s < stages; ++s) {
    if (s > 0) {
      mju_copy(d->qpos, q0.data(), m->nq);
      mj_integratePos(m, d->qpos, v_k.data(), node[s] * h);
      for (std::size_t i = 0; i < nv; ++i) d->qvel[i] = v0[i] + node[s] * h * a_k[i];
      for (std::size_t i = 0; i < z.size(); ++i) z[i] = z0[i] + node[s] * h * z_k[i];
    }
    apply_forces(t + node[s] * h, z, z_k);
    mj_forwardSkip(m, d, mjSTAGE_NONE, 1);
    v_k.assign(d->qvel, d->qvel + m->nv);
    a_k.assign(d->qacc, d->qacc + m->nv);
    mju_copy(d->qacc_warmstart, d->qacc, m->nv);
    for (std::size_t i = 0; i < nv; ++i) {
      v_sum[i] += weight[s] * v_k[i];
      a_sum[i] += weight[s] * a_k[i];
    }
    for (std::size_t i = 0; i < z.size(); ++i) z_sum[i] += weight[s] * z_k[i];
  }
  mju_copy(d->qpos, q0.data(), m->nq);
  mj_integratePos(m, d->qpos, v_sum.data(), h);
  for (std::size_t i = 0; i < nv; ++i) d->qvel[i] = v0[i] + h * a_sum[i];
  for (std::size_t i = 0; i < z.size(); ++i) z[i] = z0[i] + h * z_sum[i];
}

}  // namespace hrp::cases
