// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/simulation/rollout_impl.h"

namespace hrp::diagnosis {

void Rollout::choose_follow_gains() {
  follow_k_.assign(static_cast<size_t>(n_), 0.0);
  follow_d_ = follow_k_;
  free_.assign(static_cast<size_t>(n_), 0);
  std::vector<double> q(static_cast<size_t>(n_)), zero(static_cast<size_t>(n_), 0.0);
  for (int j = 0; j < n_; ++j) q[j] = smooth_.joints[index(j)].q[smooth_.start];
  bodies_.evaluate(recording_.time[smooth_.start], smooth_.start, q.data(), zero.data(), mass_.data(), bias_.data());
  for (int j = 0; j < n_; ++j) {
    follow_k_[j] = mass_[j * n_ + j] * kFollow * kFollow;
    follow_d_[j] = 2.0 * mass_[j * n_ + j] * kFollow;
  }
}

void Rollout::follow(int j, double t, double q, double v) {
  const SmoothJoint& joint = smooth_.joints[index(j)];
  const Moment at = find_moment(recording_.time, t, near_);
  const int m = motor_[j];
  f_[m] += follow_k_[j] * (at.of(joint.q) - q) + follow_d_[j] * (at.of(joint.qd) - v);
  K_[m] += follow_k_[j];
  D_[m] += follow_d_[j];
}

double Rollout::calc_drive(int j, double t, const RolloutState& x) {
  const JointLaws& law = laws(j);
  const JointColumns& columns = recording_.joints[index(j)];
  const int m = motor_[j];
  if (plant_.effort_driven) {
    free_[j] = 1;
    const auto& effort = smooth_.effort[index(j)];
    return effort.empty()
               ? 0.0
               : interpolate(recording_.time, effort, t + get_effort_delay(plant_, j) - law.command_delay, near_);
  }
  free_[j] = 0;
  if (columns.command.empty()) return 0.0;
  double position, rate;
  const double origin = recording_.time.front();
  read_command(
      recording_.time, columns,
      origin + (t - origin) * (1.0 + plant_.timing.clock_skew) - law.command_delay - plant_.timing.command_shift, near_,
      &position, &rate);
  const double u = calc_servo_effort(law, position - x.q[m] - law.joint_offset, rate - x.v[m], 0.0);
  if (std::abs(u) > law.effort_limit && !within_[j]) free_[j] = 1;
  if (free_[j]) return u > 0.0 ? law.effort_limit : -law.effort_limit;
  K_[m] = law.kp;
  D_[m] = law.kd;
  return u;
}

double Rollout::calc_friction(int j, double q, double v, double* slope) const {
  const JointLaws& law = laws(j);
  *slope += law.viscous;
  return -law.viscous * v + (law.cogging_amplitude != 0.0 ? calc_cogging(law, q) : 0.0);
}

double Rollout::calc_level(int j, double speed, double load, double b) const {
  return std::max(1e-9, calc_friction_level(laws(j), speed, load, b > 0.0 ? 1.0 : -1.0));
}

void Rollout::add_gear(int j, double drive, double bend) {
  const int m = motor_[j];
  gear_[j] =
      calc_holding_level(laws(j), drive, bend) / std::max(1e-300, std::abs(drive)) * std::min(1.0, std::abs(bend));
  f_[m] += gear_[j] * drive;
  K_[m] *= 1.0 + gear_[j];
  D_[m] *= 1.0 + gear_[j];
}

double Rollout::calc_dry_friction(int j, double h, double v, double load, double b, double* slope) {
  const double d = laws(j).presliding, speed = std::abs(v), k = calc_level(j, speed, load, b) / d;
  const double slip = speed / d, bend = 1.0 - (v > 0.0 ? b : -b) / d, c = kGamma * h;
  fb_[j] = v - slip * b;
  bristle_k_[j] = k;
  bristle_a_[j] = 1.0 / (1.0 + c * slip);
  bristle_slip_[j] = bend;
  *slope += c * k * std::max(0.0, bend) * bristle_a_[j];
  return -k * b;
}

double Rollout::lag_effort(int j, double h, double u, const RolloutState& x) {
  const double lag = laws(j).lag;
  const int m = motor_[j];
  lag_factor_[j] = 0.0;
  if (!(lag > 0.0)) return u;
  const double w = kGamma * h / lag;
  fu_[j] = (u - x.u[j]) / lag;
  lag_factor_[j] = 1.0 / (1.0 + w);
  lag_k_[j] = K_[m] * w;
  lag_d_[j] = D_[m] * w;
  K_[m] *= w / (1.0 + w);
  D_[m] *= w / (1.0 + w);
  return x.u[j];
}

void Rollout::add_hysteresis(int j, double h, const RolloutState& x) {
  const JointLaws& law = laws(j);
  const double factor = calc_hysteresis_rate_factor(x.z[j], x.v[j]);
  f_[j] -= law.hysteresis_stiffness * law.hysteresis_yield * x.z[j];
  fz_[j] = factor * x.v[j] / law.hysteresis_yield;
  D_[j] += kGamma * h * law.hysteresis_stiffness * factor;
}

void Rollout::calc_joint_forces(int j, double t, double h, const RolloutState& x) {
  const JointLaws& law = laws(j);
  const int m = motor_[j];
  double u = lag_effort(j, h, calc_drive(j, t, x), x);
  const TorqueSlope slope = calc_given_slope(law, u, x.v[m]);
  u = calc_given_torque(law, u, x.v[m]);
  if (slope.over_effort == 0.0) free_[j] = 1;
  K_[m] *= slope.over_effort;
  D_[m] = D_[m] * slope.over_effort - std::min(0.0, slope.over_v);
  const double drive = u + calc_friction(j, x.q[m], x.v[m], &D_[m]);
  f_[m] += drive;
  if (law.backdriven > 0.0) add_gear(j, drive, x.b[j] / law.presliding);
  if (law.has_friction()) f_[m] += calc_dry_friction(j, h, x.v[m], u, x.b[j], &D_[m]);
  if (free_[j] && !free_running_) follow(j, t, x.q[m] + law.joint_offset, x.v[m]);
  if (law.cogging_amplitude != 0.0) K_[m] -= calc_cogging_slope(law, x.q[m]);
  if (law.spring_stiffness != 0.0) {
    f_[j] -= law.spring_stiffness * (x.q[j] - law.spring_rest);
    K_[j] += law.spring_stiffness;
  }
  if (law.hysteresis_stiffness > 0.0) add_hysteresis(j, h, x);
  if (law.elastic) calc_transmission(j, x);
}

void Rollout::calc_transmission(int j, const RolloutState& x) {
  const JointLaws& law = laws(j);
  const int m = motor_[j];
  const double twist = calc_backlash_twist(law.gap, x.q[m] - x.q[j]);
  const bool open = law.gap > 0.0 && twist == 0.0;
  const double k = open ? 0.0 : law.stiffness, d = open ? 0.0 : law.damping;
  const double effort = k * twist + d * (x.v[m] - x.v[j]);
  f_[j] += effort;
  f_[m] -= effort;
  K_[j] += k;
  K_[m] += k;
  D_[j] += d;
  D_[m] += d;
  couple_k_[m] = -k;
  couple_d_[m] = -d;
}

void Rollout::evaluate(double t, double h, const RolloutState& x) {
  std::fill(f_.begin(), f_.end(), 0.0);
  std::fill(K_.begin(), K_.end(), 0.0);
  std::fill(D_.begin(), D_.end(), 0.0);
  for (int j = 0; j < n_; ++j) calc_joint_forces(j, t, h, x);
  bodies_.evaluate(t, near_, x.q.data(), x.v.data(), mass_.data(), bias_.data());
  for (int j = 0; j < n_; ++j) f_[j] -= bias_[j];
  std::fill(M_.begin(), M_.end(), 0.0);
  for (int i = 0; i < n_; ++i) {
    for (int j = 0; j < n_; ++j) M_[i * N_ + j] = mass_[i * n_ + j];
    M_[motor_[i] * N_ + motor_[i]] += (1.0 + gear_[i]) * plant_.rotor[index(i)];
    // First-order correction for the lag of the servo's rate. It is limited to half of the inertia.
    double& own = M_[motor_[i] * N_ + motor_[i]];
    if (K_[motor_[i]] > 0.0) own -= std::min(laws(i).kd * plant_.timing.rate_lag, 0.5 * own);
    if (laws(i).elastic) M_[motor_[i] * N_ + motor_[i]] += laws(i).motor_inertia;
  }
}

}  // namespace hrp::diagnosis
