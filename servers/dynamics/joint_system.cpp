// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/joint_system.h"

#include <algorithm>
#include <cmath>

#include "common/base/has.h"
#include "common/multibody/kinematics.h"
#include "common/multibody/mass_matrix.h"

namespace hrp {
namespace {

// Holding adds this many times the joint's own inertia: what is left of its motion, 1e-9 of the load's, is then set to
// zero, and the holding effort keeps seven digits.
constexpr double kHoldFactor = 1e9;
// A mimic joint follows as an oscillator of this frequency, critically damped.
constexpr double kMimicRate = 2.0 * M_PI * 20.0;  // [1/s]

}  // namespace

JointSystem::JointSystem(const Model& model, const Scenario& scenario, const std::vector<JointLaws>& laws)
    : laws_(laws) {
  const auto n = static_cast<size_t>(model.num_joints());
  for (int i = 0; i < model.num_joints(); ++i) {
    const JointSpec& joint = model.spec().joint(i);
    const auto has_drive = [&](const JointSpec& j) { return j.actuated && !has(scenario.unactuated, j.name); };
    const bool mimic = joint.mimic.joint >= 0;
    // A mimic joint goes where its leader's command goes, unless nothing drives the leader.
    const bool driven = has_drive(mimic ? model.spec().joint(joint.mimic.joint) : joint);
    mimics_.push_back(joint.mimic);
    const bool perfect = scenario.perfect_joints || scenario.drive == "motion";
    kinds_.push_back(perfect && driven ? Kind::kPerfect : (mimic ? Kind::kMimic : Kind::kDrive));
    if (scenario.joint_stops) {
      laws_[static_cast<size_t>(i)].lower = joint.lower;
      laws_[static_cast<size_t>(i)].upper = joint.upper;
    }
  }
  memories_.resize(n);
  next_memories_.resize(n);
  steps_.resize(n);
  hold_inertia_.resize(n);
  target_v_.resize(n);
  target_q_.resize(n);
}

void JointSystem::reset(const Model& model, const State& state, Data* data) {
  update_kinematics(model, state, data);
  const Eigen::MatrixXd& M = update_mass_matrix(model, data);
  constexpr double kStopRate = 2.0 * M_PI * 10.0;  // [1/s] of a stop with the joint's own inertia
  for (size_t i = 0; i < laws_.size(); ++i) {
    const int k = model.num_base() + static_cast<int>(i);
    const double inertia = std::max(M(k, k) + laws_[i].motor_inertia, 1e-9);
    hold_inertia_[i] = kHoldFactor * inertia;
    // Behind an elastic transmission, the rotor is not in the mass matrix.
    const double own = std::max(M(k, k) + (laws_[i].elastic ? laws_[i].motor_inertia : 0.0), 1e-9);
    if (kinds_[i] == Kind::kMimic) {
      laws_[i].kp = own * kMimicRate * kMimicRate;
      laws_[i].kd = 2.0 * own * kMimicRate;
      laws_[i].effort_limit = kUnlimited;
    }
    if (std::isfinite(laws_[i].lower) || std::isfinite(laws_[i].upper)) {
      laws_[i].stop_stiffness = own * kStopRate * kStopRate;
      laws_[i].stop_damping = own * kStopRate;
    }
    memories_[i] = make_drive_memory(laws_[i], state.q[static_cast<Eigen::Index>(i)]);
  }
  next_memories_ = memories_;
}

ReferenceSample JointSystem::find_reference(int joint, const State& state, const Reference& reference, double horizon,
                                            double fraction) const {
  const MimicSpec& mimic = mimics_[static_cast<size_t>(joint)];
  if (mimic.joint < 0) return reference.get(joint, fraction);
  ReferenceSample followed{state.q[mimic.joint] + horizon * state.qd[mimic.joint], state.qd[mimic.joint], 0.0};
  if (kinds_[static_cast<size_t>(joint)] == Kind::kPerfect) followed = reference.get(mimic.joint, fraction);
  return {mimic.multiplier * followed.q + mimic.offset, mimic.multiplier * followed.qd, 0.0};
}

void JointSystem::start(const State& state, const Reference& reference, double horizon, double fraction, double dt) {
  for (size_t i = 0; i < laws_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const ReferenceSample sample = find_reference(static_cast<int>(i), state, reference, horizon, fraction);
    DriveInput in;
    in.q = state.q[k];
    in.v = state.qd[k];
    in.reference = sample.q;
    in.rate = sample.qd;
    in.forward = sample.effort;
    in.horizon = horizon;
    in.dt = dt;
    start_drive(laws_[i], memories_[i], in, &steps_[i]);
    if (kinds_[i] != Kind::kPerfect) continue;
    target_q_[i] = find_reference(static_cast<int>(i), state, reference, dt, 1.0).q;
    target_v_[i] = (target_q_[i] - in.q) / dt;
  }
}

double JointSystem::calc_held_acceleration(int joint, const State& state) const {
  const auto i = static_cast<size_t>(joint);
  const double target = kinds_[i] == Kind::kPerfect ? target_v_[i] : 0.0;
  return (target - state.qd[joint]) / steps_[i].in.dt;
}

void JointSystem::linearise(const State& state, Eigen::VectorXd* effort, Eigen::VectorXd* inertia_extra) {
  for (size_t i = 0; i < laws_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    DriveStep& step = steps_[i];
    linearise_drive(laws_[i], memories_[i], &step);
    if (is_held(static_cast<int>(i))) {
      (*effort)[k] = hold_inertia_[i] * calc_held_acceleration(static_cast<int>(i), state);
      (*inertia_extra)[k] = hold_inertia_[i];
    } else {
      (*effort)[k] = step.link.at(state.qd[k]);
      (*inertia_extra)[k] = step.in.horizon > 0.0 ? step.in.dt * step.link.b : 0.0;
    }
  }
}

bool JointSystem::resolve(const State& state, const double* qdd) {
  bool changed = false;
  for (size_t i = 0; i < laws_.size(); ++i) {
    if (kinds_[i] == Kind::kPerfect) continue;
    const int k = static_cast<int>(i);
    const double held = hold_inertia_[i] * (calc_held_acceleration(k, state) - qdd[i]);
    const double v = steps_[i].held ? 0.0 : state.qd[k] + steps_[i].in.dt * qdd[i];
    changed |= resolve_drive(laws_[i], memories_[i], v, held, &steps_[i]);
  }
  return changed;
}

void JointSystem::finish(const State& state, const double* qdd, Eigen::VectorXd* qd, Eigen::VectorXd* effort,
                         Eigen::VectorXd* servo_effort) {
  for (size_t i = 0; i < laws_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double held = hold_inertia_[i] * (calc_held_acceleration(static_cast<int>(i), state) - qdd[i]);
    if (steps_[i].held) (*qd)[k] = 0.0;
    if (kinds_[i] == Kind::kPerfect) (*qd)[k] = target_v_[i];
    next_memories_[i] = memories_[i];
    const DriveEfforts efforts = finish_drive(laws_[i], steps_[i], (*qd)[k], held, &next_memories_[i]);
    (*effort)[k] = kinds_[i] == Kind::kPerfect ? held : efforts.link;
    (*servo_effort)[k] = kinds_[i] == Kind::kPerfect ? held : efforts.servo;
  }
}

void JointSystem::put_perfect_positions(Eigen::VectorXd* q) const {
  for (size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] == Kind::kPerfect) (*q)[static_cast<Eigen::Index>(i)] = target_q_[i];
  }
}

}  // namespace hrp
