// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/generator/reality.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "diagnosis/generator/reality_impl.h"

namespace hrp::cases {
namespace {

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

}  // namespace

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

void Reality::Impl::reset() {
  mj_resetData(m, d);
  for (int j = 0; j < count(); ++j) {
    const auto i = static_cast<std::size_t>(j);
    d->qpos[q_link[i]] = d->qpos[q_motor[i]] = joint(robot, j).start - joints[i].offset;
  }
  z.assign(3 * static_cast<std::size_t>(count()), 0.0);
}

void Reality::Impl::check_sane(double t) const {
  for (int i = 0; i < m->nq; ++i) {
    if (!std::isfinite(d->qpos[i])) throw InsaneCase{kDiverges};
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
    if (!std::isfinite(d->qpos[i])) throw InsaneCase{kDiverges};
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
    out.link_torque.push_back(torque[0] * axis[0] + torque[1] * axis[1] + torque[2] * axis[2] -
                              beside[static_cast<std::size_t>(j)]);
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

std::vector<Reading> Reality::run(const Commands& commands, const std::vector<double>& times, const Vec3& push,
                                  bool soles_lift) {
  Impl& r = *impl_;
  r.commands = &commands;
  r.push = push;
  r.choose_step(times.empty() ? 0.0 : times.back(), soles_lift);
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
  for (int j = 0; j < r.count(); ++j)
    commands->position[static_cast<std::size_t>(j)].assign(2, joint(r.robot, j).start);
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
      q.push_back(position[j]);
      v.push_back(0);
      const std::size_t last = q.size() - 1;
      v[last - 1] = (q[last] - q[last - 2]) / (2 * period);
    }
    ++tick;
  }
  return out;
}

}  // namespace hrp::cases
