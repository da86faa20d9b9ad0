// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/simulation/rollout.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/command_reader.h"
#include "diagnosis/simulation/rollout_impl.h"

namespace hrp::diagnosis {
namespace {

constexpr int kFiner = 4;  // factor on the number of steps where a joint reverses

}  // namespace

Rollout::Rollout(const Plant& plant, const Recording& recording, const SmoothRecording& smooth, std::vector<int> joints,
                 Bodies* bodies)
    : plant_(plant),
      recording_(recording),
      smooth_(smooth),
      joints_(std::move(joints)),
      bodies_(*bodies),
      n_(static_cast<int>(joints_.size())) {
  N_ = n_;
  for (int j = 0; j < n_; ++j) motor_.push_back(laws(j).elastic ? N_++ : j);
  const auto n = static_cast<size_t>(n_), size = static_cast<size_t>(N_);
  for (std::vector<double>* by_coordinate : {&x_.q, &x_.v, &predicted_.q, &predicted_.v, &f_, &K_, &D_, &k1q_, &k1v_,
                                             &k2q_, &k2v_, &rhs_, &couple_k_, &couple_d_}) {
    by_coordinate->assign(size, 0.0);
  }
  for (std::vector<double>* by_joint : {&x_.u,   &x_.z,  &x_.b,  &predicted_.u, &predicted_.z, &predicted_.b, &fu_,
                                        &fz_,    &fb_,   &k1u_,  &k1z_,         &k1b_,         &lag_factor_,  &lag_k_,
                                        &lag_d_, &gear_, &bias_, &bristle_k_,   &bristle_a_,   &bristle_slip_}) {
    by_joint->assign(n, 0.0);
  }
  within_.assign(n, 0);
  A_.assign(size * size, 0.0);
  M_.assign(size * size, 0.0);
  mass_.assign(n * n, 0.0);
  choose_follow_gains();
}

bool Rollout::run(const RolloutOptions& options, const StartState* start, std::vector<double>* readings,
                  std::vector<LinkMotion>* links) {
  const size_t rows = recording_.size();
  links_ = links;
  free_running_ = options.free_running;
  if (links) prepare_links(rows);
  begin(smooth_.start);
  if (start) correct(*start);
  write(smooth_.start, readings);
  long taken = 0;
  for (size_t k = smooth_.start; k + 1 < rows; ++k) {
    const double t = recording_.time[k], dt = recording_.time[k + 1] - t;
    if (options.until > 0.0 && t - recording_.time[smooth_.start] > options.until) break;
    const double longest = wants_small_steps() ? 0.5 * options.max_step : options.max_step;
    const int steps = std::max(1, static_cast<int>(std::ceil(dt / longest - 1e-9)));
    near_ = k;
    for (int i = 0; i < steps; ++i) {
      const double h = dt / steps;
      const int finer = is_turning(h) ? kFiner : 1;
      taken += finer;
      for (int f = 0; f < finer; ++f) {
        if (!step_within_limits(t + h * (i + static_cast<double>(f) / finer), h / finer)) return false;
      }
    }
    near_ = k + 1;
    write(k + 1, readings);
  }
  if (options.work) *options.work += taken * n_;
  return true;
}

void Rollout::begin(size_t k) {
  for (int j = 0; j < n_; ++j) {
    const SmoothJoint& joint = smooth_.joints[index(j)];
    x_.q[j] = joint.q[k] - laws(j).joint_offset;
    x_.v[j] = joint.qd[k];
    x_.z[j] = 0.0;
  }
  near_ = k;
  start_transmissions(k);
  for (int j = 0; j < n_; ++j) x_.u[j] = calc_drive(j, recording_.time[k], x_);
  start_bristles(k);
}

void Rollout::correct(const StartState& start) {
  for (int j = 0; j < n_; ++j) {
    const size_t i = index(j), m = static_cast<size_t>(motor_[j]);
    if (!start.q.empty()) {
      x_.q[m] += start.q[i];
      x_.v[m] += start.v[i];
    }
    if (motor_[j] != j && !start.link_q.empty()) {
      x_.q[j] += start.link_q[i];
      x_.v[j] += start.link_v[i];
    }
    if (!start.bristles.empty()) x_.b[j] += start.bristles[i] * laws(j).presliding;
    if (!start.memory.empty()) x_.z[j] = std::min(1.0, std::max(-1.0, start.memory[i]));
    limit_bristles(j);
  }
}

void Rollout::start_bristles(size_t k) {
  std::vector<double> tau(static_cast<size_t>(n_));
  bodies_.calc_efforts(k, tau.data());
  for (int j = 0; j < n_; ++j) {
    x_.b[j] = 0.0;
    if (!laws(j).has_friction()) continue;
    const double missing = calc_given_torque(laws(j), x_.u[j], x_.v[motor_[j]]) - tau[static_cast<size_t>(j)];
    const double level = calc_level(j, 0.0, x_.u[j], missing) + calc_holding_level(laws(j), x_.u[j], missing);
    x_.b[j] = missing / level * laws(j).presliding;
    limit_bristles(j);
  }
}

void Rollout::start_transmissions(size_t k) {
  if (N_ == n_) return;
  std::vector<double> tau(static_cast<size_t>(n_));
  bodies_.calc_efforts(k, tau.data());
  for (int j = 0; j < n_; ++j) {
    if (!laws(j).elastic) continue;
    x_.q[motor_[j]] = x_.q[j];
    x_.v[motor_[j]] = x_.v[j];
    x_.q[j] -= tau[j] / laws(j).stiffness + (tau[j] > 0.0 ? 0.5 : -0.5) * laws(j).gap;
  }
}

void Rollout::write(size_t k, std::vector<double>* readings) {
  double* row = readings->data() + k * plant_.laws.size() * kQuantities;
  for (int j = 0; j < n_; ++j) {
    const int m = motor_[j];
    double* out = row + index(j) * kQuantities;
    out[0] = x_.q[m] + laws(j).joint_offset;
    out[1] = x_.v[m];
    out[2] = calc_drive(j, recording_.time[k], x_);
    if (!links_) continue;
    LinkMotion& link = (*links_)[index(j)];
    link.q[k] = x_.q[j];
    link.qd[k] = x_.v[j];
  }
}

void Rollout::prepare_links(size_t rows) {
  links_->resize(plant_.laws.size());
  for (int j = 0; j < n_; ++j) {
    (*links_)[index(j)].q.assign(rows, 0.0);
    (*links_)[index(j)].qd.assign(rows, 0.0);
  }
}

bool simulate_recording(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                        const RolloutOptions& options, std::vector<double>* readings, const StartState* start) {
  readings->assign(recording.size() * plant.laws.size() * kQuantities, 0.0);
  std::vector<int> joints(plant.laws.size());
  for (size_t j = 0; j < joints.size(); ++j) joints[j] = static_cast<int>(j);
  const std::unique_ptr<Bodies> bodies = make_robot_bodies(plant, smooth);
  if (!Rollout(plant, recording, smooth, joints, bodies.get()).run(options, start, readings, nullptr)) return false;
  apply_faults(plant, recording, readings);
  return true;
}

bool simulate_joint(const Plant& plant, const Recording& recording, const SmoothRecording& smooth,
                    const RobotPath& path, int joint, const RolloutOptions& options, std::vector<double>* readings,
                    std::vector<LinkMotion>* links) {
  const std::unique_ptr<Bodies> bodies = make_path_bodies(path[static_cast<size_t>(joint)], recording.time);
  return Rollout(plant, recording, smooth, {joint}, bodies.get()).run(options, nullptr, readings, links);
}

void apply_faults(const Plant& plant, const Recording& recording, std::vector<double>* readings) {
  const size_t width = plant.faults.size(), rows = recording.size();
  for (size_t c = 0; c < width; ++c) {
    const SensorErrors& fault = plant.faults[c];
    if (fault.delay > 0.0) {
      std::vector<double> series(rows);
      for (size_t k = 0; k < rows; ++k) series[k] = (*readings)[k * width + c];
      for (size_t k = 0; k < rows; ++k) {
        (*readings)[k * width + c] = interpolate(recording.time, series, recording.time[k] - fault.delay, k);
      }
    }
    const double bias = fault.bias.x(), scale = fault.scale.x();
    if (bias == 0.0 && scale == 1.0) continue;
    for (size_t k = 0; k < rows; ++k) (*readings)[k * width + c] = scale * (*readings)[k * width + c] + bias;
  }
}

}  // namespace hrp::diagnosis
