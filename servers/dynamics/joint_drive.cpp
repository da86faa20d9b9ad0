// SPDX-License-Identifier: BSD-3-Clause
#include "servers/dynamics/joint_drive.h"

#include <algorithm>
#include <cmath>

namespace hrp {
namespace {

// Regimes may change so often within one step; then the last answer stands and the next step decides anew.
constexpr int kMaxChanges = 4;

signed char sign_of(double x) { return x > 0.0 ? 1 : (x < 0.0 ? -1 : 0); }

double get_direction(FrictionRegime regime) {
  return regime == FrictionRegime::kForward ? 1.0 : (regime == FrictionRegime::kBackward ? -1.0 : 0.0);
}

FrictionRegime make_moving(double direction) {
  return direction > 0.0 ? FrictionRegime::kForward : FrictionRegime::kBackward;
}

// Side of the limit on which an effort lies: 0 within.
signed char find_limit_side(double effort, double limit) {
  return std::abs(effort) > limit ? sign_of(effort) : static_cast<signed char>(0);
}

double calc_motor_q(const JointLaws& laws, const DriveMemory& memory, const DriveStep& step) {
  return laws.elastic ? memory.motor_q : step.in.q;
}

double get_motor_v(const JointLaws& laws, const DriveMemory& memory, const DriveStep& step) {
  return laws.elastic ? memory.motor_v : step.in.v;
}

// Before its limit.
AffineEffort calc_free_servo(const JointLaws& laws, double motor_q, const DriveInput& in) {
  const double error = in.reference - (motor_q + laws.joint_offset);
  return {calc_servo_effort(laws, error, in.rate, in.forward), laws.kp * in.horizon + laws.kd};
}

AffineEffort calc_servo(const JointLaws& laws, double motor_q, const DriveStep& step) {
  if (step.regime.servo != 0) return {step.regime.servo * laws.effort_limit, 0.0};
  return calc_free_servo(laws, motor_q, step.in);
}

// What the motor gets from the servo's effort: first-order lag, torque constant.
AffineEffort calc_drive(const JointLaws& laws, const DriveMemory& memory, const AffineEffort& servo, double horizon) {
  AffineEffort drive = servo;
  if (laws.lag > 0.0) {
    const double g = horizon / laws.lag;
    drive = {(memory.lag_effort + g * servo.a) / (1.0 + g), g * servo.b / (1.0 + g)};
  }
  return {laws.torque_scale * drive.a, laws.torque_scale * drive.b};
}

// Laws of the drive that depend on speed, about the speed at the start of the step: a torque that falls with speed is
// implicit, as friction is.
void add_drive_terms(const JointLaws& laws, double motor_v, AffineEffort* motor) {
  JointLaws behind = laws;  // scale and saturation are in the torque already
  behind.torque_scale = 1.0;
  behind.saturation = kUnlimited;
  const double before = motor->at(motor_v), torque = calc_given_torque(behind, before, motor_v);
  const TorqueSlope slope = calc_given_slope(behind, before, motor_v);
  const double b = slope.over_effort * motor->b - std::min(0.0, slope.over_v);
  *motor = {torque + b * motor_v, b};
}

// While the motor brakes, a gear that is hard to turn backwards multiplies what comes to it, the rotor's inertia
// included. `share` of it: 1 in motion.
void add_gear(const JointLaws& laws, double motor_v, double direction, double share, DriveStep* step) {
  AffineEffort& motor = step->motor;
  if (laws.backdriven == 0.0 || motor.at(motor_v) * direction >= 0.0) return;
  const double gain = share * laws.backdriven / (1.0 - laws.backdriven),
               rotor = gain * laws.motor_inertia / step->in.dt;
  motor = {(1.0 + gain) * motor.a + rotor * motor_v, (1.0 + gain) * motor.b + rotor};
}

// Dahl's friction (AIAA J. 14, 1976) is level x bend / displacement, where the bend [rad] follows the motor and
// saturates: d bend / dx = 1 - sgn(v) bend / displacement.
bool bends(const JointLaws& laws) { return laws.bends && laws.has_friction(); }

double calc_bend_slope(const JointLaws& laws, double bend, double direction) {
  return std::max(0.0, 1.0 - direction * bend / laws.presliding);
}

// Bend behind a step of the motor [rad].
double calc_bend(const JointLaws& laws, double bend, double step) {
  const double d = laws.presliding, end = step < 0.0 ? -d : d;
  return end + (bend - end) * std::exp(-std::abs(step) / d);
}

// Bend at the end of the step over motor v': along its slope, as far as it goes. Continuous where one becomes the
// other.
AffineEffort calc_bend_end(const JointLaws& laws, const DriveMemory& memory, double direction, const DriveStep& step) {
  if (step.in.horizon == 0.0) return {memory.bend, 0.0};
  if (step.regime.slips) return {direction * laws.presliding, 0.0};
  return {memory.bend, -calc_bend_slope(laws, memory.bend, direction) * step.in.horizon};
}

void add_bend(const JointLaws& laws, const DriveMemory& memory, double motor_v, double direction, DriveStep* step) {
  const double side = memory.bend == 0.0 ? direction : sign_of(memory.bend);
  add_gear(laws, motor_v, side, std::min(1.0, std::abs(memory.bend) / laws.presliding), step);
  const double stiffness = calc_friction_level(laws, std::abs(motor_v), step->load, side) / laws.presliding;
  const AffineEffort bend = calc_bend_end(laws, memory, direction, *step);
  step->motor.a -= stiffness * bend.a;
  step->motor.b -= stiffness * bend.b;
}

void add_motor_terms(const JointLaws& laws, const DriveMemory& memory, double motor_q, double motor_v,
                     DriveStep* step) {
  AffineEffort& motor = step->motor;
  motor.b += laws.viscous;
  if (laws.cogging_amplitude != 0.0) {
    motor.a += calc_cogging(laws, motor_q);
    motor.b += step->in.horizon * std::max(0.0, -calc_cogging_slope(laws, motor_q));
  }
  const double direction = get_direction(step->regime.friction);
  if (direction == 0.0) return;
  if (bends(laws)) return add_bend(laws, memory, motor_v, direction, step);
  add_gear(laws, motor_v, direction, 1.0, step);
  motor.a -= direction * calc_friction_level(laws, std::abs(motor_v), step->load, direction);
}

// Transmission: effort = twist.a + twist.b (motor v' - link v').
AffineEffort calc_transmission(const JointLaws& laws, const DriveMemory& memory, const DriveStep& step) {
  if (laws.gap > 0.0 && step.regime.gap == 0) return {0.0, 0.0};
  const double twist = memory.motor_q - step.in.q - 0.5 * laws.gap * step.regime.gap;
  return {laws.stiffness * twist, laws.stiffness * step.in.horizon + laws.damping};
}

// Motor behind an elastic transmission: J (motor v' - motor v) / dt = motor - twist, solved for motor v' and put into
// the transmission's effort, which then depends on the link alone.
void eliminate_motor(const JointLaws& laws, const DriveMemory& memory, DriveStep* step) {
  step->twist = calc_transmission(laws, memory, *step);
  const AffineEffort& t = step->twist;
  if (step->regime.friction == FrictionRegime::kHeld) {
    step->motor_v = {0.0, 0.0};
  } else if (step->in.horizon == 0.0) {
    step->motor_v = {memory.motor_v, 0.0};
  } else {
    const double rate = laws.motor_inertia / step->in.dt;
    const double all = rate + step->motor.b + t.b;
    step->motor_v = {(rate * memory.motor_v + step->motor.a - t.a) / all, -t.b / all};
  }
  step->link = {t.a + t.b * step->motor_v.a, t.b * (1.0 + step->motor_v.b)};
}

void add_link_terms(const JointLaws& laws, const DriveMemory& memory, DriveStep* step) {
  const DriveInput& in = step->in;
  AffineEffort& link = step->link;
  link.a += laws.spring_stiffness * (laws.spring_rest - in.q);
  link.b += laws.spring_stiffness * in.horizon + laws.spring_damping;
  if (laws.spring_hardening > 0.0) {
    const double k = laws.spring_stiffness * laws.spring_hardening * in.q * in.q;
    link.a -= k * in.q;
    link.b += 3.0 * k * in.horizon;
  }
  if (laws.hysteresis_stiffness > 0.0) {
    link.a -= laws.hysteresis_stiffness * laws.hysteresis_yield * memory.hysteresis;
    link.b += laws.hysteresis_stiffness * in.horizon * calc_hysteresis_rate_factor(memory.hysteresis, in.v);
  }
  if (step->regime.stop != 0) {
    const double limit = step->regime.stop < 0 ? laws.lower : laws.upper;
    link.a += laws.stop_stiffness * (limit - in.q);
    link.b += laws.stop_stiffness * in.horizon + laws.stop_damping;
  }
}

signed char find_gap_side(const JointLaws& laws, double twist) { return sign_of(calc_backlash_twist(laws.gap, twist)); }

signed char find_stop_side(const JointLaws& laws, double q) {
  if (laws.stop_stiffness <= 0.0) return 0;
  return q < laws.lower ? -1 : (q > laws.upper ? 1 : 0);
}

double calc_transmission_effort(const DriveStep& step, double v) {
  return step.twist.a + step.twist.b * (step.motor_v.at(v) - v);
}

bool change(signed char now, signed char* regime) {
  const bool changed = now != *regime;
  *regime = now;
  return changed;
}

bool resolve_limits(const JointLaws& laws, const DriveMemory& memory, double motor_v, DriveStep* step) {
  const bool limited = step->regime.servo != 0;
  const AffineEffort servo = limited ? calc_free_servo(laws, calc_motor_q(laws, memory, *step), step->in) : step->servo;
  bool changed = change(find_limit_side(servo.at(motor_v), laws.effort_limit), &step->regime.servo);
  const double drive = calc_drive(laws, memory, step->servo, step->in.horizon).at(motor_v);
  changed |= change(find_limit_side(drive, laws.saturation), &step->regime.saturation);
  return changed;
}

// The direction is that of motion; the bend goes along its slope until that passes the end.
bool resolve_bend(const JointLaws& laws, const DriveMemory& memory, double motor_v, DriveStep* step) {
  const FrictionRegime before = step->regime.friction;
  const bool slipped = step->regime.slips;
  if (motor_v != 0.0) step->regime.friction = make_moving(motor_v);
  const double direction = get_direction(step->regime.friction);
  const double end = memory.bend + calc_bend_slope(laws, memory.bend, direction) * step->in.horizon * motor_v;
  step->regime.slips = direction * end > laws.presliding;
  return step->regime.friction != before || step->regime.slips != slipped;
}

// Stays held while what holding takes is within the static level; a mover that would turn round is held first.
bool resolve_friction(const JointLaws& laws, double motor_v, double holding, DriveStep* step) {
  FrictionRegime& regime = step->regime.friction;
  if (regime == FrictionRegime::kNone) return false;
  if (regime == FrictionRegime::kHeld) {
    const double direction = holding > 0.0 ? -1.0 : 1.0;  // of the motion that friction prevents
    if (std::abs(holding) <= calc_static_level(laws, step->load, direction)) return false;
    regime = make_moving(direction);
    return true;
  }
  if (motor_v * get_direction(regime) >= 0.0) return false;
  regime = FrictionRegime::kHeld;
  return true;
}

bool resolve_transmission(const JointLaws& laws, const DriveMemory& memory, double v, DriveStep* step) {
  if (!laws.elastic || laws.gap <= 0.0) return false;
  const double h = step->in.horizon;
  const double twist = memory.motor_q + h * step->motor_v.at(v) - step->in.q - h * v;
  signed char side = find_gap_side(laws, twist);
  // A side carries only by pushing: damping does not make the teeth stick.
  if (side != 0 && side == step->regime.gap && calc_transmission_effort(*step, v) * side < 0.0) side = 0;
  return change(side, &step->regime.gap);
}

bool resolve_stop(const JointLaws& laws, double v, DriveStep* step) {
  if (step->regime.stop == 0) {
    return change(find_stop_side(laws, step->in.q + step->in.horizon * v), &step->regime.stop);
  }
  const double limit = step->regime.stop < 0 ? laws.lower : laws.upper;
  const double effort = laws.stop_stiffness * (limit - step->in.q - step->in.horizon * v) - laws.stop_damping * v;
  return effort * step->regime.stop > 0.0 && change(0, &step->regime.stop);
}

double calc_holding_effort(const JointLaws& laws, const DriveMemory& memory, double v, double held_effort,
                           const DriveStep& step) {
  if (!laws.elastic) return held_effort - step.link.a;
  return calc_transmission_effort(step, v) - step.motor.a - laws.motor_inertia * memory.motor_v / step.in.dt;
}

}  // namespace

DriveMemory make_drive_memory(const JointLaws& laws, double q) {
  DriveMemory memory;
  memory.motor_q = laws.elastic ? q : 0.0;
  return memory;
}

void start_drive(const JointLaws& laws, const DriveMemory& memory, const DriveInput& in, DriveStep* step) {
  step->in = in;
  step->regime = DriveRegime{};
  DriveRegime& regime = step->regime;
  const double motor_q = calc_motor_q(laws, memory, *step);
  const double motor_v = get_motor_v(laws, memory, *step);
  step->servo = calc_free_servo(laws, motor_q, in);
  regime.servo = find_limit_side(step->servo.at(motor_v), laws.effort_limit);
  if (regime.servo != 0) step->servo = calc_servo(laws, motor_q, *step);
  const double drive = calc_drive(laws, memory, step->servo, in.horizon).at(motor_v);
  regime.saturation = find_limit_side(drive, laws.saturation);
  step->load = std::clamp(drive, -laws.saturation, laws.saturation);
  if (laws.has_friction())
    regime.friction = motor_v == 0.0 && !bends(laws) ? FrictionRegime::kHeld : make_moving(motor_v);
  if (laws.elastic) regime.gap = find_gap_side(laws, memory.motor_q - in.q);
  regime.stop = find_stop_side(laws, in.q + in.horizon * in.v);
}

void linearise_drive(const JointLaws& laws, const DriveMemory& memory, DriveStep* step) {
  const double motor_q = calc_motor_q(laws, memory, *step), motor_v = get_motor_v(laws, memory, *step);
  step->servo = calc_servo(laws, motor_q, *step);
  step->motor = calc_drive(laws, memory, step->servo, step->in.horizon);
  if (step->regime.saturation != 0) step->motor = {step->regime.saturation * laws.saturation, 0.0};
  if (!laws.terms.empty()) add_drive_terms(laws, motor_v, &step->motor);
  add_motor_terms(laws, memory, motor_q, motor_v, step);
  step->held = !laws.elastic && step->regime.friction == FrictionRegime::kHeld;
  step->link = step->motor;
  if (laws.elastic) eliminate_motor(laws, memory, step);
  add_link_terms(laws, memory, step);
}

bool resolve_drive(const JointLaws& laws, const DriveMemory& memory, double v, double held_effort, DriveStep* step) {
  if (step->regime.changes >= kMaxChanges) return false;
  const double motor_v = laws.elastic ? step->motor_v.at(v) : v;
  const double holding = calc_holding_effort(laws, memory, v, held_effort, *step);
  bool changed =
      bends(laws) ? resolve_bend(laws, memory, motor_v, step) : resolve_friction(laws, motor_v, holding, step);
  changed |= resolve_limits(laws, memory, motor_v, step);
  changed |= resolve_transmission(laws, memory, v, step);
  changed |= resolve_stop(laws, v, step);
  if (changed) ++step->regime.changes;
  return changed;
}

DriveEfforts finish_drive(const JointLaws& laws, const DriveStep& step, double v, double held_effort,
                          DriveMemory* memory) {
  const double dt = step.in.dt;
  double motor_v = laws.elastic ? step.motor_v.at(v) : v;
  DriveEfforts efforts;
  efforts.link = step.held ? held_effort : step.link.at(v);
  efforts.servo = step.servo.at(motor_v);
  if (laws.lag > 0.0) {
    const double g = dt / laws.lag;
    memory->lag_effort = (memory->lag_effort + g * efforts.servo) / (1.0 + g);
  }
  if (laws.hysteresis_stiffness > 0.0) {
    const double rate = calc_hysteresis_rate_factor(memory->hysteresis, step.in.v) * v / laws.hysteresis_yield;
    memory->hysteresis = std::clamp(memory->hysteresis + dt * rate, -1.0, 1.0);
  }
  if (bends(laws)) memory->bend = calc_bend(laws, memory->bend, dt * motor_v);
  if (!laws.elastic) return efforts;
  if (step.in.horizon == 0.0) {  // explicit: the motor moves by the efforts at the start
    const double net = step.motor.at(memory->motor_v) - calc_transmission_effort(step, step.in.v);
    const bool held = step.regime.friction == FrictionRegime::kHeld;
    motor_v = held ? 0.0 : memory->motor_v + dt * net / laws.motor_inertia;
    if (!bends(laws) && motor_v * get_direction(step.regime.friction) < 0.0) motor_v = 0.0;
  }
  memory->motor_v = motor_v;
  memory->motor_q += dt * motor_v;
  return efforts;
}

}  // namespace hrp
