// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/terms.h"

#include <algorithm>
#include <cmath>

#include "common/effects/link_law.h"

namespace hrp::diagnosis::standing {
namespace {

Vector3d get3(const std::vector<double>& p, size_t at = 0) { return {p[at], p[at + 1], p[at + 2]}; }

// What the experiment states about a joint's drive.
JointTerms make_stated_terms(const JointLaws& laws) {
  JointTerms t;
  t.viscous = laws.viscous, t.coulomb = laws.coulomb, t.asymmetry = laws.asymmetry, t.load = laws.load_ratio;
  t.stribeck_velocity = laws.stribeck_velocity;
  if (t.stribeck_velocity > 0) t.excess = std::max(0.0, laws.static_level - laws.coulomb);
  t.rotor = laws.motor_inertia, t.lag = laws.lag, t.delay = laws.command_delay;
  t.drive.torque_scale = laws.torque_scale, t.drive.saturation = laws.saturation, t.drive.terms = laws.terms;
  t.offset = laws.joint_offset;
  t.spring = laws.spring_stiffness, t.moment = -laws.spring_stiffness * laws.spring_rest;
  t.cogging_sin = laws.cogging_amplitude * std::cos(laws.cogging_phase);
  t.cogging_cos = laws.cogging_amplitude * std::sin(laws.cogging_phase), t.periods = laws.cogging_periods;
  t.hysteresis = laws.hysteresis_stiffness, t.yield = laws.hysteresis_yield, t.gap = laws.gap;
  if (laws.elastic) t.compliance = 1 / laws.stiffness;
  return t;
}

void add_friction(const StandEffect& e, JointTerms* j) {
  switch (e.id) {
    case StandId::kViscous:
      j->viscous += e.p[0];
      break;
    case StandId::kCoulomb:
      j->coulomb += e.p[0], j->asymmetry += e.p[1];
      break;
    case StandId::kLoadFriction:
      j->load += e.p[0];
      break;
    case StandId::kHysteresis:
      j->hysteresis = e.p[0], j->yield = e.p[1];
      break;
    default:  // Stribeck
      j->coulomb += e.p[0], j->excess += e.p[1], j->stribeck_velocity = e.p[2], j->viscous += e.p[3];
  }
}

void add_drive(const StandEffect& e, JointTerms* j) {
  switch (e.id) {
    case StandId::kRotorInertia:
      j->rotor += e.p[0];
      break;
    case StandId::kSpring:
      j->spring += e.p[0], j->moment += e.p[1];
      break;
    case StandId::kTorqueConstant:
      j->drive.torque_scale *= e.p[0];
      break;
    case StandId::kSaturation:
      j->drive.saturation = std::min(j->drive.saturation, e.p[0]);
      break;
    case StandId::kCogging:
      j->cogging_sin = e.p[0], j->cogging_cos = e.p[1], j->periods = e.p[2];
      break;
    case StandId::kCommandDelay:
      j->delay += e.p[0];
      break;
    case StandId::kActuatorLag:
      j->lag += e.p[0];
      break;
    case StandId::kElasticity:
      j->compliance += e.p[0], j->rotor += e.p[1];
      break;
    case StandId::kBacklash:
      j->gap = e.p[0], j->rotor += e.p[1], j->compliance += e.p[2];
      break;
    case StandId::kJointOffset:
      j->offset += e.p[0];
      break;
    default:
      add_friction(e, j);
  }
}

void add_joint_sensor(const StandEffect& e, JointTerms* j) {
  switch (e.id) {
    case StandId::kEffortBias:
      j->effort_bias = e.p[0];
      break;
    case StandId::kEffortScale:
      j->effort_scale = e.p[0];
      break;
    case StandId::kEffortDelay:
      j->effort_delay = e.p[0];
      break;
    case StandId::kVelocityBias:
      j->velocity_bias = e.p[0];
      break;
    case StandId::kVelocityScale:
      j->velocity_scale = e.p[0];
      break;
    case StandId::kVelocityDelay:
      j->velocity_delay = e.p[0];
      break;
    case StandId::kPositionBias:
      j->position_bias = e.p[0];
      break;
    case StandId::kPositionScale:
      j->position_scale = e.p[0];
      break;
    default:
      j->position_delay = e.p[0];
  }
}

// A payload written in mass and mass x com, in which forces are linear. A step of a fit may ask for a moment without a
// mass, or for a mass far outside the robot: that has no inertia that would mean anything.
constexpr double kFar = 2.0;  // [m]
void add_payload_by_moment(double mass, const Vector3d& moment, LinkInertia* link) {
  if (mass > 0 && moment.norm() < kFar * mass) return add_payload(mass, moment / mass, 0.0, link);
  const Vector3d sum = link->mass * link->p_LLcm_L + moment;
  link->mass = std::max(1e-6, link->mass + mass);
  link->p_LLcm_L = sum / link->mass;
}

void add_link(const StandEffect& e, LinkInertia* link, Vector3d* force_W) {
  if (e.id == StandId::kMassError) {
    const double scale = std::max(1e-6, e.p[0]);  // a step of a fit may go too far
    link->mass *= scale, link->I_LLcm_L *= scale;
  }
  if (e.id == StandId::kComError) link->p_LLcm_L += get3(e.p);
  if (e.id == StandId::kExternalForce) *force_W += get3(e.p);
  if (e.id != StandId::kPayload) return;
  add_payload_by_moment(e.p[0], get3(e.p, 1), link);
}

void add_wrench(const StandEffect& e, size_t feet, std::vector<WrenchTerms>* wrenches) {
  const size_t part = static_cast<size_t>(e.place) / feet;  // 0 all, 1 force, 2 torque
  WrenchTerms& w = (*wrenches)[static_cast<size_t>(e.place) % feet];
  for (size_t i = 0; i < 2; ++i) {
    if (part != 0 && part != i + 1) continue;
    if (e.id == StandId::kWrenchDelay) w.delay[i] = e.p[0];
    if (e.id == StandId::kWrenchMisalignment) w.rpy[i] = get3(e.p);
  }
  switch (e.id) {
    case StandId::kForceBias:
      w.force_bias = get3(e.p);
      break;
    case StandId::kTorqueBias:
      w.torque_bias = get3(e.p);
      break;
    case StandId::kForceScale:
      w.force_scale = e.p[0];
      break;
    case StandId::kTorqueScale:
      w.torque_scale = e.p[0];
      break;
    case StandId::kWrenchSkew:
      w.skew = e.p[0];
      break;
    default:
      break;
  }
}

void add_imu(const StandEffect& e, ImuTerms* imu) {
  for (int i = 0; i < 3; ++i) {
    if (e.place != 0 && e.place != i + 1) continue;
    if (e.id == StandId::kImuDelay) imu->delay[i] = e.p[0];
    if (e.id == StandId::kImuMisalignment) imu->rpy[i] = get3(e.p);
  }
  switch (e.id) {
    case StandId::kGyroBias:
      imu->gyro_bias = get3(e.p);
      break;
    case StandId::kAccelerometerBias:
      imu->accelerometer_bias = get3(e.p);
      break;
    case StandId::kGyroScale:
      imu->gyro_scale = e.p[0];
      break;
    case StandId::kAccelerometerScale:
      imu->accelerometer_scale = e.p[0];
      break;
    case StandId::kImuSkew:
      imu->skew = e.p[0];
      break;
    default:
      break;
  }
}

void add_foot(const StandEffect& e, std::vector<FootTerms>* feet) {
  const bool hard = e.id == StandId::kFootHardening;
  const size_t size = kFootParameters + (hard ? 1 : 0);
  for (size_t f = 0; f < feet->size(); ++f) {
    const double* p = &e.p[f * size];
    FootTerms& foot = (*feet)[f];
    foot.soft = true;
    for (int a = 0; a < 2; ++a) {
      foot.inverse_k[a] = p[2 * a], foot.c_over_k[a] = p[2 * a + 1], foot.moment[a] = p[8 + a];
    }
    foot.inverse_kz = p[4], foot.shift = {p[5], p[6], p[7]};
    if (hard) foot.hardening = p[kFootParameters];
  }
}

}  // namespace

Terms::Terms(const StandProblem& problem, const StandHypothesis& hypothesis)
    : joints(static_cast<size_t>(problem.tree.num_joints())),
      wrenches(problem.feet.size()),
      feet(problem.feet.size()),
      tree(problem.tree),
      force_W(problem.force_W) {
  force_W.resize(problem.tree.links.size(), Vector3d::Zero());
  for (size_t j = 0; j < problem.laws.size(); ++j) joints[j] = make_stated_terms(problem.laws[j]);
  for (const StandEffect& e : hypothesis) {
    const auto place = static_cast<size_t>(e.place);
    if (is_joint(e.id)) add_drive(e, &joints[place]);
    if (is_joint_sensor(e.id)) add_joint_sensor(e, &joints[place]);
    if (is_link(e.id)) add_link(e, &tree.links[place].inertia, &force_W[place]);
    if (is_wrench(e.id)) add_wrench(e, problem.feet.size(), &wrenches);
    if (is_imu(e.id)) add_imu(e, &imu);
    if (is_foot(e.id)) add_foot(e, &feet);
    if (e.id == StandId::kGroundSlope) slope_roll = e.p[0], slope_pitch = e.p[1];
    if (e.id == StandId::kGroundFriction) friction = e.p[0];
  }
}

}  // namespace hrp::diagnosis::standing
