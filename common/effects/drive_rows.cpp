// SPDX-License-Identifier: BSD-3-Clause
// Effects of a joint's drive and its encoder.
#include <algorithm>
#include <cmath>

#include "common/effects/effect_rows.h"

namespace hrp {
namespace {

using P = EffectParameter;

// Shapes of limits are tried in coarse steps only.
const std::vector<double> kLimitStarts{0.75, 1, 1.3};

EffectInfo make_torque_constant() {
  EffectInfo row = make_row(EffectId::kTorqueConstant, "torque_constant_error", PlaceKind::kJoint, EffectFamily::kGain,
                            "the true torque is a fixed multiple of the logged effort",
                            {P("scale", "1").as_factor().bounds(0, 10).search(0.05, 5).size(0.02)});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->torque_scale *= p[0]; };
  row.torque.num_columns = 1;
  row.torque.calc_columns = [](const JointSample& s, const double*, double* c) { c[0] = s.effort; };
  row.torque.make_parameters = [](const double* x, const double*, double* p) {
    p[0] = 1.0 - x[0];
    return x[0] < 0.95 && x[0] > -4.0;
  };
  row.linear = true;
  return row;
}

EffectInfo make_saturation() {
  EffectInfo row = make_row(
      EffectId::kSaturation, "torque_saturation", PlaceKind::kJoint, EffectFamily::kLimits,
      "the true torque is limited below what is logged",
      {P("limit", "N m").absent_at(kUnbounded).bounds(0, kUnbounded).search(1e-3, 1e9).size(0.5).starts(kLimitStarts)});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->saturation = std::min(at.joint->saturation, p[0]);
  };
  row.torque.num_columns = 1;
  row.torque.shapes = {{0.02}, {0.035}, {0.06}, {0.1}, {0.2}, {0.35}, {0.5}, {0.65}, {0.8}, {0.92}};
  row.torque.shape_of_effort = true;
  row.torque.calc_columns = [](const JointSample& s, const double* shape, double* c) {
    c[0] = s.effort - std::max(-shape[0], std::min(shape[0], s.effort));
  };
  row.torque.make_parameters = [](const double* x, const double* shape, double* p) {
    p[0] = shape[0];
    return x[0] > 0.3 && x[0] < 3.0;
  };
  row.always_shows = true;
  row.smooth = false;
  return row;
}

// |torque| <= stall_torque (1 - |v| / max_speed)
double limit_by_speed(const double* p, double torque, double v) {
  const double limit = std::max(0.0, p[0] * (1.0 - std::abs(v) / p[1]));
  return std::clamp(torque, -limit, limit);
}

// A drive whose torque hardly falls up to the joint's largest speed has a constant limit.
SpecialCase find_constant_limit(const double* p, double speed, double) {
  constexpr double kHardly = 0.05;  // of the torque, as for friction: so weak a part may be no part
  if (speed < kHardly * p[1]) return {EffectId::kSaturation, {p[0]}};
  return {};
}

EffectInfo make_velocity_limit() {
  EffectInfo row = make_row(
      EffectId::kNamed, "velocity_limit", PlaceKind::kJoint, EffectFamily::kLimits,
      "the drive gives less torque the faster it turns",
      {P("stall_torque", "N m").bounds(0, kUnbounded).search(1e-3, 1e9).size(0.02).as_walked().starts(kLimitStarts),
       P("max_speed", "rad/s").bounds(1e-3, kUnbounded).search(0.05, 1e4).size(0.02).as_walked().starts(kLimitStarts)});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->terms.push_back({&limit_by_speed, {p[0], p[1]}});
  };
  row.torque.num_columns = 1;
  // A servo that gets less than it asks for asks for more: the limit may be a small share of the largest effort.
  for (double stall : {0.05, 0.1, 0.17, 0.3, 0.5, 0.8, 1.3}) {
    for (double speed : {1.05, 1.4, 2.0}) row.torque.shapes.push_back({stall, speed});
  }
  row.torque.shape_of_effort = row.torque.shape_of_speed = true;
  row.torque.calc_columns = [](const JointSample& s, const double* shape, double* c) {
    c[0] = s.effort - limit_by_speed(shape, s.effort, s.v);
  };
  row.torque.make_parameters = [](const double* x, const double* shape, double* p) {
    p[0] = shape[0];
    p[1] = shape[1];
    return x[0] > 0.3 && x[0] < 3.0;
  };
  row.find_special_case = &find_constant_limit;
  row.always_shows = true;
  row.smooth = false;
  return row;
}

// Valves that overlap, bridges with a dead time, servos with a dead band: what is asked for below a width does nothing,
// and of the rest the width is missing.
double take_dead_zone(const double* p, double torque, double) { return torque - std::clamp(torque, -p[0], p[0]); }

EffectInfo make_dead_zone() {
  EffectInfo row = make_row(EffectId::kNamed, "dead_zone", PlaceKind::kJoint, EffectFamily::kLimits,
                            "the drive gives nothing for small efforts, and less by as much for larger ones",
                            {P("width", "N m").absent_at(0).bounds(0, kUnbounded).size(0.02).starts(kLimitStarts)});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->terms.push_back({&take_dead_zone, {p[0], 0.0}});
  };
  row.torque.num_columns = 1;
  row.torque.shapes = {{0.02}, {0.035}, {0.06}, {0.1}, {0.17}, {0.3}, {0.5}};
  row.torque.shape_of_effort = true;
  row.torque.calc_columns = [](const JointSample& s, const double* shape, double* c) {
    c[0] = s.effort - take_dead_zone(shape, s.effort, s.v);
  };
  row.torque.make_parameters = [](const double* x, const double* shape, double* p) {
    p[0] = shape[0];
    return x[0] > 0.3 && x[0] < 3.0;
  };
  row.smooth = false;
  return row;
}

double take_constant(const double* p, double torque, double) { return torque - p[0]; }

EffectInfo make_constant_torque() {
  EffectInfo row =
      make_row(EffectId::kNamed, "constant_torque", PlaceKind::kJoint, EffectFamily::kZero,
               "a constant torque acts against the positive direction", {P("torque", "N m").absent_at(0).size(0.1)});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->terms.push_back({&take_constant, {p[0], 0.0}}); };
  row.torque.num_columns = 1;
  row.torque.calc_columns = [](const JointSample&, const double*, double* c) { c[0] = 1.0; };
  row.torque.make_parameters = [](const double* x, const double*, double* p) {
    p[0] = x[0];
    return true;
  };
  row.linear = true;
  return row;
}

EffectInfo make_lag() {
  EffectInfo row =
      make_row(EffectId::kLag, "actuator_lag", PlaceKind::kJoint, EffectFamily::kTiming,
               "the drive's torque lags behind its command",
               {P("time_constant", "s").absent_at(0).bounds(0, 1).size(0.002).starts({0.3, 1}, {0.003, 0.01})});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->lag += p[0]; };
  row.torque.num_columns = 1;
  row.torque.calc_columns = [](const JointSample& s, const double*, double* c) { c[0] = s.effort_rate; };
  row.torque.make_parameters = [](const double* x, const double*, double* p) {
    p[0] = x[0];
    return x[0] > 0.0;
  };
  row.linear = true;
  return row;
}

EffectInfo make_delay() {
  EffectInfo row = make_row(
      EffectId::kDelay, "command_delay", PlaceKind::kJoint, EffectFamily::kTiming, "commands reach the servo late",
      {P("delay", "s").absent_at(0).bounds(0, 1).size(0.002).starts({0.3, 1}, {0.005, 0.02}).probed_by(5e-4)});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->command_delay += p[0]; };
  row.linear = row.by_command = true;
  return row;
}

EffectInfo make_drive_timing() {
  EffectInfo row = make_row(EffectId::kDriveTiming, "drive_timing", PlaceKind::kJoint, EffectFamily::kTiming,
                            "the drive's loop takes its time",
                            {P("shift", "s").absent_at(0).search(-2e-4, 2e-4).size(1e-5).internal()});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->command_delay += p[0]; };
  row.reported = false;
  row.linear = true;
  return row;
}

EffectInfo make_timing() {
  EffectInfo row =
      make_row(EffectId::kTiming, "timing", PlaceKind::kNone, EffectFamily::kTiming, "the drive's loop takes its time",
               {P("shift", "s").absent_at(0).search(-2e-4, 2e-4).size(1e-5).internal(),
                P("rate_lag", "s").absent_at(0).search(-2e-4, 2e-4).size(1e-5).internal()});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.timing->command_shift = p[0];
    at.timing->rate_lag = p[1];
  };
  row.reported = false;
  row.linear = true;
  return row;
}

EffectInfo make_joint_offset() {
  EffectInfo row = make_row(EffectId::kJointOffset, "joint_offset", PlaceKind::kJoint, EffectFamily::kZero,
                            "the encoder's zero is off",
                            {P("offset", "rad").absent_at(0).bounds(-3.2, 3.2).size(0.002).probed_by(1e-3)});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->joint_offset += p[0]; };
  row.felt_elsewhere = true;
  return row;
}

}  // namespace

std::vector<EffectInfo> list_drive_rows() {
  return {make_torque_constant(), make_saturation(),  make_velocity_limit(), make_dead_zone(),
          make_constant_torque(), make_lag(),         make_delay(),          make_timing(),
          make_drive_timing(),    make_joint_offset()};
}

}  // namespace hrp
