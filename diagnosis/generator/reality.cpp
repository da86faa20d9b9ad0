// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/reality.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "diagnosis/generator/joint_reality.h"
#include "diagnosis/generator/walk_forces.h"

namespace hrp::cases {
namespace {

constexpr double kPostures = 0.05;  // [s] between those for which a step is found
constexpr double kWalkMargin = 0.7;  // of the step found where the robot starts: knees and hips turn less elsewhere
constexpr double kWalkRest = 0.6;    // [s] on its feet before the controller begins

mjModel* load_model(const std::string& xml) {
  auto vfs = std::make_unique<mjVFS>();
  mj_defaultVFS(vfs.get());
  mj_makeEmptyFileVFS(vfs.get(), "case.xml", static_cast<int>(xml.size()));
  std::memcpy(vfs->filedata[0], xml.data(), xml.size());
  char error[512] = "";
  mjModel* model = mj_loadXML("case.xml", vfs.get(), error, sizeof error);
  mj_deleteVFS(vfs.get());
  if (!model) throw std::runtime_error(std::string("MuJoCo refuses the generated model: ") + error);
  return model;
}

// Bush of one foot: addresses of slide, roll, pitch and the six coefficients.
struct Bush {
  int qpos = 0, dof = 0;
  double k[3]{}, c[3]{}, hardening_angle = 0;
};

// A horizontal force that comes and goes: amplitude [N], frequency [Hz], direction in the world's plane [rad].
struct Gust {
  int body = 0;
  double amplitude = 0, frequency = 0, direction = 0;
};

}  // namespace

struct Reality::Impl {
  RobotPlan robot;
  std::vector<JointReality> joints;
  mjModel* m = nullptr;
  mjData* d = nullptr;
  std::vector<int> q_link, v_link, q_motor, v_motor;  // addresses; motor = link where nothing is elastic
  std::vector<Bush> bushes;
  std::vector<std::pair<int, Vec3>> forces;  // body, constant force in world axes [N]
  std::vector<Gust> gusts;
  std::unique_ptr<WalkForces> walk_forces;
  int push_body = -1;
  Vec3 push{};
  const Commands* commands = nullptr;
  double dt = 2e-4;
  std::vector<double> beside;  // torque on each link that does not go through its transmission [N m]
  std::vector<double> z;  // lag states [N m], then Bouc-Wen states [rad], then warmth of the coils

  ~Impl() {
    if (d) mj_deleteData(d);
    if (m) mj_deleteModel(m);
  }

  int count() const { return joint_count(robot); }
  void find_addresses(const std::vector<Hidden>& hidden);
  double find_step();
  void choose_step(double end);
  double find_rate(bool stiffness);
  double calc_servo_effort(int j, double t, const double* q, const double* v) const;
  void apply_forces(double t, const std::vector<double>& states, std::vector<double>& rates);
  void apply_joint(int j, double t, const std::vector<double>& states, std::vector<double>& rates);
  void update_dry_friction(double t);
  void step(double t, double h);
  void reset();
  Reading read(double t);
  void check_sane(double t) const;
  bool has_fallen() const;
};

void Reality::Impl::find_addresses(const std::vector<Hidden>& hidden) {
  for (int j = 0; j < count(); ++j) {
    const std::string& name = joint(robot, j).name;
    const int at = mj_name2id(m, mjOBJ_JOINT, name.c_str());
    const int motor = mj_name2id(m, mjOBJ_JOINT, (name + "_motor").c_str());
    q_link.push_back(m->jnt_qposadr[at]);
    v_link.push_back(m->jnt_dofadr[at]);
    q_motor.push_back(m->jnt_qposadr[motor >= 0 ? motor : at]);
    v_motor.push_back(m->jnt_dofadr[motor >= 0 ? motor : at]);
  }
  for (const Hidden& h : hidden) {
    if (h.effect == "external_force") forces.emplace_back(mj_name2id(m, mjOBJ_BODY, h.where.c_str()), h.get3("force"));
    if (h.effect == "gust") {
      gusts.push_back(
          {mj_name2id(m, mjOBJ_BODY, h.where.c_str()), h.get("amplitude"), h.get("frequency"), h.get("direction")});
    }
    if (h.where_kind != "foot" || h.effect == "sticky_sole") continue;
    for (const FootPlan& foot : robot.feet) {
      if (robot.links[static_cast<std::size_t>(foot.link)].name != h.where) continue;
      const int slide = mj_name2id(m, mjOBJ_JOINT, (foot.wrench + "_z").c_str());
      Bush bush{m->jnt_qposadr[slide],
                m->jnt_dofadr[slide],
                {h.get("kz"), h.get("k_roll"), h.get("k_pitch")},
                {h.get("cz"), h.get("c_roll"), h.get("c_pitch")},
                h.get("hardening_angle")};
      bushes.push_back(bush);
    }
  }
  walk_forces = std::make_unique<WalkForces>(robot, hidden, m);
  if (robot.floating)
    push_body = mj_name2id(m, mjOBJ_BODY, robot.links[static_cast<std::size_t>(robot.imu_link)].name.c_str());
}

// Largest rate of M^-1 D (damping) or frequency of M^-1 K, by power iteration from a fixed start.
double Reality::Impl::find_rate(bool stiffness) {
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
    mj_solveM(m, d, x.data(), y.data(), 1);
    double norm = 0;
    for (double value : x) norm += value * value;
    rate = std::sqrt(norm);
    if (rate == 0) return 0;
    for (double& value : x) value /= rate;
  }
  return stiffness ? std::sqrt(rate) : rate;
}

// The longest stable step [s] at the present posture. Arms: Runge-Kutta 4 (stable to 2.8). Standing robots: the midpoint
// rule (to 2.0), because contact costs more than it.
double Reality::Impl::find_step() {
  mj_kinematics(m, d);
  mj_comPos(m, d);
  mj_crb(m, d);
  mj_factorM(m, d);
  const double limit = robot.floating ? 1.2 : 1.6;
  return std::min({robot.floating ? 3e-4 : 2.5e-4, limit / find_rate(false), 1.0 / find_rate(true)});
}

// Wherever the commands lead: a joint about which the arm is stretched turns a tenth of the inertia it turned at the
// start, and the servo that was stable there hums at the frequency of the steps here.
void Reality::Impl::choose_step(double end) {
  reset();
  dt = find_step();
  for (double t = 0; t < end; t += kPostures) {
    for (int j = 0; j < count(); ++j) {
      const auto i = static_cast<std::size_t>(j);
      double c = 0, cd = 0;
      commands->find(j, t, c, cd);
      d->qpos[q_link[i]] = d->qpos[q_motor[i]] = c - joints[i].offset;
    }
    dt = std::min(dt, find_step());
  }
  if (dt < 2e-5) throw InsaneCase{"servo too stiff for the masses"};
}

void Reality::Impl::reset() {
  mj_resetData(m, d);
  for (int j = 0; j < count(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    d->qpos[q_link[i]] = d->qpos[q_motor[i]] = joint(robot, j).start - joints[i].offset;
  }
  z.assign(3 * static_cast<std::size_t>(count()), 0.0);
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
  d->qfrc_applied[v_motor[i]] +=
      calc_drive_torque(real, driven, vm, states[2 * n + i], t) + calc_motor_side_torque(real, qm, vm, states[n + i], t);
  const double link_side = calc_link_side_torque(real, ql, vl);
  d->qfrc_applied[v_link[i]] += link_side, beside[i] += link_side;
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
    beside[i] -= real.coupling * turn, beside[o] -= real.coupling * turn;
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
    for (std::size_t i = 0; i < nv; ++i) v_sum[i] += weight[s] * v_k[i], a_sum[i] += weight[s] * a_k[i];
    for (std::size_t i = 0; i < z.size(); ++i) z_sum[i] += weight[s] * z_k[i];
  }
  mju_copy(d->qpos, q0.data(), m->nq);
  mj_integratePos(m, d->qpos, v_sum.data(), h);
  for (std::size_t i = 0; i < nv; ++i) d->qvel[i] = v0[i] + h * a_sum[i];
  for (std::size_t i = 0; i < z.size(); ++i) z[i] = z0[i] + h * z_sum[i];
}

void Reality::Impl::check_sane(double t) const {
  for (int i = 0; i < m->nq; ++i) {
    if (!std::isfinite(d->qpos[i])) throw InsaneCase{"diverges"};
  }
  for (int j = 0; j < count(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    double c = 0, cd = 0;
    commands->find(j, t, c, cd);
    if (std::abs(d->qpos[q_link[i]] - c) > 0.5) throw InsaneCase{joint(robot, j).name + " leaves its command", t};
  }
  if (robot.floating && std::hypot(d->qpos[4], d->qpos[5]) > 0.15) throw InsaneCase{"falls"};
}

// Tilted by 40 degrees, or its base down to 60 % of where it began.
bool Reality::Impl::has_fallen() const {
  for (int i = 0; i < m->nq; ++i) {
    if (!std::isfinite(d->qpos[i])) throw InsaneCase{"diverges"};
  }
  return std::hypot(d->qpos[4], d->qpos[5]) > 0.34 || d->qpos[2] < 0.6 * robot.base_position[2];
}

Reading Reality::Impl::read(double t) {
  std::vector<double> rates(z.size());
  apply_forces(t, z, rates);
  mj_forward(m, d);
  Reading out;
  out.time = t;
  for (int j = 0; j < count(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    out.position.push_back(d->qpos[q_motor[i]] + joints[i].offset);
    out.velocity.push_back(d->qvel[v_motor[i]]);
    out.effort.push_back(calc_servo_effort(j, t, d->qpos, d->qvel));
    out.link_position.push_back(d->qpos[q_link[i]]);
  }
  if (robot.floating) {
    std::copy_n(d->qpos, 3, out.base_position.begin());
    std::copy_n(d->qpos + 3, 4, out.base_orientation.begin());
  }
  auto sensor = [&](const std::string& name) {
    return d->sensordata + m->sensor_adr[mj_name2id(m, mjOBJ_SENSOR, name.c_str())];
  };
  if (!robot.imu.empty()) {
    std::copy_n(sensor("gyro"), 3, out.imu_rate.begin());
    std::copy_n(sensor("acceleration"), 3, out.imu_acceleration.begin());
    std::copy_n(sensor("orientation"), 4, out.imu_orientation.begin());
  }
  for (int j = 0; robot.joint_torques && j < count(); ++j) {
    const JointPlan& plan = joint(robot, j);
    const double* torque = sensor(plan.name + "_torque");  // what the parent exerts on the link
    const Vec3& axis = plan.axis;
    out.link_torque.push_back(torque[0] * axis[0] + torque[1] * axis[1] + torque[2] * axis[2] - beside[static_cast<std::size_t>(j)]);
  }
  for (std::size_t a = 0; !robot.wrist.empty() && a < 3; ++a) {
    out.wrist_force[a] = -sensor(robot.wrist + "_force")[a];
    out.wrist_torque[a] = -sensor(robot.wrist + "_torque")[a];
  }
  for (const FootPlan& foot : robot.feet) {
    Vec3 force, torque;
    // MuJoCo reports what the parent exerts on the foot; the format wants what the foot exerts on its parent.
    for (std::size_t a = 0; a < 3; ++a) {
      force[a] = -sensor(foot.wrench + "_force")[a];
      torque[a] = -sensor(foot.wrench + "_torque")[a];
    }
    out.foot_force.push_back(force);
    out.foot_torque.push_back(torque);
  }
  return out;
}

Reality::Reality(const RobotPlan& robot, const std::vector<Hidden>& hidden) : impl_(std::make_unique<Impl>()) {
  impl_->robot = robot;
  impl_->joints = make_joint_realities(robot, hidden);
  impl_->m = load_model(make_mjcf(robot, hidden));
  impl_->d = mj_makeData(impl_->m);
  impl_->find_addresses(hidden);
}

Reality::~Reality() = default;

std::vector<Reading> Reality::run(const Commands& commands, const std::vector<double>& times, const Vec3& push) {
  Impl& r = *impl_;
  r.commands = &commands;
  r.push = push;
  r.choose_step(times.empty() ? 0.0 : times.back());
  r.reset();
  std::vector<Reading> out;
  double t = r.robot.floating ? -2.5 : -1.5;  // long enough to come to rest
  for (double at : times) {
    while (t < at - 1e-9) {
      // Stops at every reading and at 0, where the push ends.
      const double next = t < -1e-9 ? std::min(at, 0.0) : at;
      const double h = std::min(r.dt, next - t);
      r.step(t, h);
      t += h;
    }
    r.check_sane(at);
    out.push_back(r.read(at));
  }
  return out;
}

std::vector<Reading> Reality::walk(const Brain& brain, double period, const std::vector<double>& times,
                                   Commands* commands) {
  Impl& r = *impl_;
  r.commands = commands;
  commands->time = {0, period};
  commands->position.assign(static_cast<std::size_t>(r.count()), {});
  commands->velocity.assign(static_cast<std::size_t>(r.count()), {0, 0});
  for (int j = 0; j < r.count(); ++j) commands->position[static_cast<std::size_t>(j)].assign(2, joint(r.robot, j).start);
  r.reset();
  r.dt = kWalkMargin * r.find_step();
  if (r.dt < 2e-5) throw InsaneCase{"servo too stiff for the masses"};
  std::vector<Reading> out;
  std::vector<double> position;
  long tick = 0;
  double t = -kWalkRest;
  for (std::size_t i = 0; i < times.size();) {
    const double think = static_cast<double>(tick) * period, at = std::min(think, times[i]);
    while (t < at - 1e-9) {
      const double h = std::min(r.dt, at - t);
      r.step(t, h);
      t += h;
    }
    if (r.has_fallen()) break;
    if (times[i] <= at + 1e-9) out.push_back(r.read(times[i++]));
    if (think > at + 1e-9) continue;
    brain(r.read(think), &position);
    commands->time.push_back(think + 2 * period);
    for (std::size_t j = 0; j < position.size(); ++j) {
      std::vector<double>&q = commands->position[j], &v = commands->velocity[j];
      q.push_back(position[j]), v.push_back(0);
      const std::size_t last = q.size() - 1;
      v[last - 1] = (q[last] - q[last - 2]) / (2 * period);
    }
    ++tick;
  }
  return out;
}

}  // namespace hrp::cases
