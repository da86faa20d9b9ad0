// SPDX-License-Identifier: BSD-3-Clause
#include "common/effects/joint_law.h"

#include <algorithm>
#include <cmath>

namespace hrp {

double calc_servo_effort(const JointLaws& laws, double error, double error_rate, double feed_forward) {
  return laws.kp * error + laws.kd * error_rate + feed_forward;
}

double calc_given_torque(const JointLaws& laws, double effort, double v) {
  double torque = std::clamp(laws.torque_scale * effort, -laws.saturation, laws.saturation);
  for (const DriveTerm& term : laws.terms) torque = term.calc_torque(term.p, torque, v);
  return torque;
}

TorqueSlope calc_given_slope(const JointLaws& laws, double effort, double v) {
  if (std::abs(laws.torque_scale * effort) > laws.saturation) return {0.0, 0.0};
  if (laws.terms.empty()) return {laws.torque_scale, 0.0};
  // Central differences: laws have corners, where one side would do as well as the other.
  const double du = 1e-6 * (1.0 + std::abs(effort)), dv = 1e-6 * (1.0 + std::abs(v));
  return {(calc_given_torque(laws, effort + du, v) - calc_given_torque(laws, effort - du, v)) / (2.0 * du),
          (calc_given_torque(laws, effort, v + dv) - calc_given_torque(laws, effort, v - dv)) / (2.0 * dv)};
}

double calc_taken_torque(const JointLaws& laws, double q, double v, double a) {
  double torque = laws.motor_inertia * a + laws.viscous * v + laws.spring_stiffness * (q - laws.spring_rest);
  if (laws.cogging_amplitude != 0.0) torque -= calc_cogging(laws, q);
  return torque;
}

double calc_direction(double v) { return std::tanh(v / kDirectionSpeed); }

double calc_friction_level(const JointLaws& laws, double speed, double load, double direction) {
  double level = laws.coulomb;
  if (laws.stribeck_velocity > 0.0) {
    const double s = speed / laws.stribeck_velocity;
    level += (std::max(laws.static_level, laws.coulomb) - laws.coulomb) * std::exp(-s * s);
  }
  level += laws.load_ratio * std::abs(load);
  return level * (1.0 + laws.asymmetry * direction);
}

double calc_static_level(const JointLaws& laws, double load, double direction) {
  const double level = std::max(laws.static_level, laws.coulomb) + laws.load_ratio * std::abs(load);
  return level * (1.0 + laws.asymmetry * direction) + calc_holding_level(laws, load, direction);
}

double calc_backdriven_level(const JointLaws& laws, double load, double direction) {
  return load * direction < 0.0 ? laws.backdriven * std::abs(load) : 0.0;
}

double calc_holding_level(const JointLaws& laws, double drive, double direction) {
  return drive * direction < 0.0 ? laws.backdriven / (1.0 - laws.backdriven) * std::abs(drive) : 0.0;
}

double calc_cogging(const JointLaws& laws, double q) {
  return laws.cogging_amplitude * std::sin(laws.cogging_periods * q + laws.cogging_phase);
}

double calc_cogging_slope(const JointLaws& laws, double q) {
  return laws.cogging_amplitude * laws.cogging_periods * std::cos(laws.cogging_periods * q + laws.cogging_phase);
}

double calc_backlash_twist(double gap, double twist) {
  const double half = 0.5 * gap;
  if (twist > half) return twist - half;
  if (twist < -half) return twist + half;
  return 0.0;
}

double calc_hysteresis_rate_factor(double z, double v) {
  const double along = v * z > 0.0 ? 1.0 : (v * z < 0.0 ? -1.0 : 0.0);
  return 1.0 - 0.5 * std::abs(z) * (1.0 + along);
}

const char* find_law_fault(const JointLaws& laws) {
  if (!(laws.kp >= 0) || !(laws.kd >= 0)) return "servo gains must not be negative";
  if (!(laws.effort_limit >= 0)) return "the effort limit must not be negative";
  if (!(laws.command_delay >= 0) || !(laws.command_delay <= 10)) return "command_delay must be between 0 and 10 s";
  if (!(laws.lag >= 0)) return "actuator_lag.time_constant must not be negative";
  if (!(laws.saturation >= 0)) return "torque_saturation.limit must not be negative";
  if (!(laws.viscous >= 0)) return "viscous friction must not be negative";
  if (!(laws.coulomb >= 0) || !(laws.static_level >= 0)) return "friction levels must not be negative";
  if (!(std::abs(laws.asymmetry) <= 1)) return "coulomb_friction.asymmetry must be between -1 and 1";
  if (!(laws.load_ratio >= 0)) return "load_dependent_friction.ratio must not be negative";
  if (!(laws.backdriven >= 0) || !(laws.backdriven < 1))
    return "backdriving_friction.ratio must be 0 or more and below 1";
  if (!(laws.stribeck_velocity >= 0)) return "stribeck_velocity must not be negative";
  if (laws.elastic && !(laws.stiffness > 0)) return "stiffness of the transmission must be positive";
  if (laws.elastic && !(laws.motor_inertia > 0)) return "rotor_inertia of an elastic transmission must be positive";
  if (!(laws.damping >= 0) || !(laws.gap >= 0)) return "damping and gap must not be negative";
  if (!(laws.spring_stiffness >= 0) || !(laws.spring_damping >= 0)) return "spring and damper must not be negative";
  if (!(laws.hysteresis_stiffness >= 0)) return "hysteresis.stiffness must not be negative";
  if (laws.hysteresis_stiffness > 0 && !(laws.hysteresis_yield > 0)) return "hysteresis.yield_angle must be positive";
  return nullptr;
}

}  // namespace hrp
