// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/drive.h"

#include <algorithm>
#include <cmath>

#include "common/effects/joint_law.h"
#include "diagnosis/data/command_reader.h"
#include "diagnosis/data/servo_gains.h"

namespace hrp::diagnosis::standing {
namespace {

constexpr double kStick = 0.004;  // [rad/s] below it a joint may stick; smoothed velocities have 0.001 of noise

// Bouc-Wen state [rad] along a recorded position. It forgets its start within a few yield angles.
std::vector<double> wind(const std::vector<double>& position, double yield, double start) {
  std::vector<double> out(1, start);
  double z = start;
  const auto rate = [&](double state, double dq) { return calc_hysteresis_rate_factor(state / yield, dq) * dq; };
  for (size_t k = 1; k < position.size(); ++k) {
    const double dq = position[k] - position[k - 1];
    z += rate(z + 0.5 * rate(z, dq), dq);
    out.push_back(z);
  }
  return out;
}

}  // namespace

Drives::Drives(const StandProblem& problem, const StandRecording& recording, const Terms& terms)
    : p_(problem), r_(recording), terms_(terms), wound_(terms.joints.size()), aside_(terms.joints.size()) {
  for (int j = 0; j < problem.tree.num_joints(); ++j) {
    servo_.push_back(get_servo_gains(problem.experiment->scenario, terms.tree.joint(j).name));
    const auto i = static_cast<size_t>(j);
    const double yield = terms.joints[i].laws.hysteresis_yield;
    if (yield <= 0) continue;
    wound_[i] = wind(recording.position[i].value, yield, 0);
    aside_[i] = wind(recording.position[i].value, yield, 0.5 * yield);
  }
  near_ = static_cast<size_t>(recording.window);
}

double Drives::read(const std::vector<double>& values, size_t k, double later) const {
  return later == 0 ? values[k] : interpolate(r_.time, values, r_.time[k] + later, k);
}

double Drives::calc_servo(size_t joint, size_t k, const DriveState& s, double* rate) const {
  const SmoothSeries& command = r_.command[joint];
  const ServoGains& servo = servo_[joint];
  const double late = terms_.joints[joint].laws.command_delay;
  const double c = read(command.value, k, -late), cd = read(command.rate, k, -late);
  const double effort = servo.kp * (c - s.encoder) + servo.kd * (cd - s.velocity);
  const bool limited = std::abs(effort) > servo.effort_limit;
  *rate = limited ? 0 : servo.kp * (cd - s.velocity) + servo.kd * (read(command.second, k, -late) - s.acceleration);
  return std::clamp(effort, -servo.effort_limit, servo.effort_limit);
}

double Drives::find_effort(size_t joint, size_t k, const DriveState& s, double* rate) const {
  return p_.has_law(joint) ? calc_servo(joint, k, s, rate) : read_log(joint, k, rate);
}

double Drives::read_log(size_t joint, size_t k, double* rate) const {
  const JointTerms& t = terms_.joints[joint];
  const SmoothSeries& effort = r_.effort[joint];
  *rate = read(effort.rate, k, t.effort.delay) / t.effort.scale.x();
  return (read(effort.value, k, t.effort.delay) - t.effort.bias.x()) / t.effort.scale.x();
}

// Missing effort after dry friction. At rest friction takes any value up to its limit, in motion its level.
double Drives::take_friction(size_t joint, size_t k, double v, double given, double missing) const {
  const JointTerms& t = terms_.joints[joint];
  if (!t.has_friction()) return missing;
  const std::vector<double>& rate = r_.position[joint].rate;
  const double before = rate[k >= near_ ? k - near_ : 0], after = rate[std::min(k + near_, rate.size() - 1)];
  const bool moving = std::abs(v) > kStick && before * v > 0 && after * v > 0;
  double level = t.laws.coulomb + t.laws.load_ratio * std::abs(given);
  if (t.excess != 0) level += t.excess * std::exp(moving ? -std::pow(v / t.laws.stribeck_velocity, 2) : 0);
  const double forward = level + t.laws.coulomb * t.laws.asymmetry,
               backward = -level + t.laws.coulomb * t.laws.asymmetry;
  if (moving) return missing - (v > 0 ? forward : backward);
  return missing - std::clamp(missing, std::min(backward, forward), std::max(backward, forward));
}

void Drives::add(size_t joint, size_t k, const DriveState& s, std::vector<double>* out) const {
  const JointTerms& t = terms_.joints[joint];
  double rate = 0;
  const double effort = p_.is_driven(joint) ? find_effort(joint, k, s, &rate) : 0;
  if (p_.is_driven(joint)) {
    const JointLaws& laws = t.laws;
    double needed = s.torque + laws.viscous * s.velocity + laws.motor_inertia * s.acceleration +
                    laws.spring_stiffness * s.link + t.moment;
    if (const double periods = laws.cogging_periods; periods > 0) {
      needed -= t.cogging_sin * std::sin(periods * s.encoder) + t.cogging_cos * std::cos(periods * s.encoder);
    }
    const double given = calc_given_torque(laws, effort - laws.lag * rate, s.velocity);
    if (!wound_[joint].empty()) needed += laws.hysteresis_stiffness * wound_[joint][k];
    out->push_back(take_friction(joint, k, s.velocity, given, given - needed));
  }
  if (p_.effort[joint] && p_.command[joint]) {
    out->push_back(read_log(joint, k, &rate) - calc_servo(joint, k, s, &rate));
  }
  if (p_.velocity[joint]) {
    const double logged = read(r_.velocity[joint].value, k, t.velocity.delay);
    out->push_back((logged - t.velocity.bias.x()) / t.velocity.scale.x() - s.velocity);
  }
}

double Drives::find_memory(size_t joint, size_t k) const {
  if (wound_[joint].empty()) return 0;
  return -terms_.joints[joint].laws.hysteresis_stiffness * (aside_[joint][k] - wound_[joint][k]);
}

void take_out_memory(const Drives& drives, const StandRecording& r, size_t joint, size_t first, size_t stride,
                     std::vector<double>* rows) {
  double a = 0, b = 0;
  for (size_t s = 0; s < r.samples.size(); ++s) {
    const double change = drives.find_memory(joint, static_cast<size_t>(r.samples[s]));
    a += change * change;
    b -= change * (*rows)[s * stride + first];
  }
  if (a == 0) return;
  const double share = std::clamp(b / a, -2.0, 2.0);  // in units of half a yield angle
  for (size_t s = 0; s < r.samples.size(); ++s) {
    (*rows)[s * stride + first] += share * drives.find_memory(joint, static_cast<size_t>(r.samples[s]));
  }
}

}  // namespace hrp::diagnosis::standing
