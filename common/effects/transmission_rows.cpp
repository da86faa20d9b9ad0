// SPDX-License-Identifier: BSD-3-Clause
// Effects between a joint's rotor and its link.
#include <algorithm>
#include <cmath>

#include "common/effects/effect_rows.h"

namespace hrp {
namespace {

using P = EffectParameter;

// A transmission that is stiff for any purpose, for a backlash whose teeth are not given.
constexpr double kToothStiffness = 1.0e4;  // [N m/rad]
constexpr double kToothDamping = 3.0;      // [N m s/rad]

// [s] damping over stiffness that fits start from.
constexpr double kGearLoss = 0.002;

void set_elastic(double stiffness, double damping, double inertia, JointLaws* laws) {
  laws->elastic = true;
  laws->stiffness = stiffness;
  laws->damping = damping;
  if (inertia > 0.0) laws->motor_inertia = inertia;
}

constexpr double kStiff = 1e4;  // [N m/rad] no stiffer than steps can follow

EffectInfo make_rotor() {
  EffectInfo row = make_row(EffectId::kRotorInertia, "rotor_inertia", PlaceKind::kJoint,
                            EffectFamily::kReflectedInertia, "the rotor's reflected inertia is missing",
                            {P("inertia", "kg m^2").absent_at(0).bounds(0, kUnbounded).size(0.01)});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->motor_inertia += p[0]; };
  row.torque.num_columns = 1;
  row.torque.calc_columns = [](const JointSample& s, const double*, double* c) { c[0] = s.a; };
  row.torque.make_parameters = [](const double* x, const double*, double* p) {
    p[0] = x[0];
    return x[0] > 0.0;
  };
  row.linear = true;
  row.rotor = 0;
  return row;
}

EffectInfo make_elasticity() {
  EffectInfo row = make_row(
      EffectId::kElasticity, "joint_elasticity", PlaceKind::kJoint, EffectFamily::kPlay, "the transmission is elastic",
      {P("stiffness", "N m/rad")
           .absent_at(kUnbounded)
           .bounds(1e-3, kUnbounded)
           .search(1, 1e7)
           .size(100)
           .starts({0.4, 1, 2.5}),
       P("damping", "N m s/rad").bounds(0, kUnbounded).search(0, 1e4).size(0.2),
       P("rotor_inertia", "kg m^2").bounds(1e-9, kUnbounded).search(1e-4, 1e3).size(0.02).starts({0.2, 1, 3})});
  row.apply = [](const double* p, const EffectTarget& at) { set_elastic(p[0], p[1], p[2], at.joint); };
  row.flexible = true;
  row.smooth = false;
  row.rotor = 2;
  row.parts = {{EffectId::kRotorInertia, {2}}};
  row.give.calc_give = [](double u, double u1, double u2, double, double* give) {
    give[0] = u;
    give[1] = u1;
    give[2] = u2;
  };
  row.give.make_parameters = [](double inertia, double give, double* p) {
    const double k = give > 1e-7 ? 1.0 / give : 1e6;
    p[0] = k;
    p[1] = kGearLoss * k;
    p[2] = std::max(0.005, inertia);
  };
  row.give.start_at = [](double inertia, double stiffness, double* p) {
    p[0] = stiffness;
    p[1] = kGearLoss * stiffness;
    p[2] = inertia;
  };
  // Compliance, from a stiffness that steps can follow, behind next to no rotor.
  row.probe.list = [](double) { return std::vector<std::vector<double>>{{kStiff, kGearLoss * kStiff, 1e-3}}; };
  row.probe.combine = [](const double* x, double, double* p) {
    p[0] = kStiff / std::max(1e-3, x[0]);
    p[1] = kGearLoss * p[0];
    p[2] = 1e-3;
    return x[0] > 0.0;
  };
  return row;
}

EffectInfo make_backlash() {
  EffectInfo row = make_row(
      EffectId::kBacklash, "backlash", PlaceKind::kJoint, EffectFamily::kPlay, "the transmission has play",
      {P("gap", "rad").absent_at(0).bounds(0, 1).size(0.002).as_walked().starts({0.3, 1}, {0.003, 0.01, 0.03, 0.08}),
       P("stiffness", "N m/rad")
           .bounds(1e-3, kUnbounded)
           .search(10, 1e6)
           .size(1000)
           .optional(kToothStiffness)
           .as_nuisance()
           .as_walked()
           .swings(3),
       P("damping", "N m s/rad")
           .bounds(0, kUnbounded)
           .search(0, 1e3)
           .size(0.5)
           .optional(kToothDamping)
           .as_nuisance()
           .as_walked(),
       P("rotor_inertia", "kg m^2").bounds(0, kUnbounded).search(1e-4, 1e3).size(0.02).optional(0).as_nuisance()});
  row.apply = [](const double* p, const EffectTarget& at) {
    if (!at.joint->elastic) set_elastic(p[1], p[2], p[3], at.joint);
    at.joint->gap = p[0];
  };
  row.flexible = true;
  row.smooth = false;
  row.rotor = 3;
  row.parts = {{EffectId::kRotorInertia, {3}}};
  row.give.calc_give = [](double u, double u1, double u2, double most, double* give) {
    const double scale = 0.05 * most + 1e-12;
    const double s = std::tanh(u / scale), c = 1.0 - s * s;
    give[0] = 0.5 * s;
    give[1] = 0.5 * c * u1 / scale;
    give[2] = 0.5 * (c * u2 / scale - 2.0 * s * c * std::pow(u1 / scale, 2));
  };
  row.give.make_parameters = [](double inertia, double give, double* p) {
    p[0] = std::min(0.1, std::max(0.001, give));
    p[1] = 1e4;
    p[2] = 5.0;
    p[3] = std::max(0.005, inertia);
  };
  row.give.start_at = [](double inertia, double stiffness, double* p) {
    p[0] = 0.01;
    p[1] = stiffness;
    p[2] = kGearLoss * stiffness;
    p[3] = inertia;
  };
  return row;
}

constexpr double kProbedRest = 0.5;  // [rad]

EffectInfo make_spring() {
  EffectInfo row = make_row(EffectId::kSpring, "parallel_spring", PlaceKind::kJoint, EffectFamily::kTorqueOverPosition,
                            "a spring acts across the joint",
                            {P("stiffness", "N m/rad").absent_at(0).bounds(0, kUnbounded).size(0.1),
                             P("rest", "rad").search(-7, 7).size(0.05).optional(0)});
  row.apply = [](const double* p, const EffectTarget& at) {
    JointLaws& laws = *at.joint;
    const double k = laws.spring_stiffness + p[0];
    if (k > 0.0) laws.spring_rest = (laws.spring_stiffness * laws.spring_rest + p[0] * p[1]) / k;
    laws.spring_stiffness = k;
  };
  row.torque.num_columns = 2;
  row.torque.calc_columns = [](const JointSample& s, const double*, double* c) {
    c[0] = s.q;
    c[1] = 1.0;
  };
  row.torque.make_parameters = [](const double* x, const double*, double* p) {
    p[0] = x[0];
    p[1] = -x[1] / x[0];
    return x[0] > 0.0 && std::abs(x[1] / x[0]) < 7.0;
  };
  row.linear = true;
  // A spring's pull is stiffness times position less a constant.
  row.probe.list = [](double k) { return std::vector<std::vector<double>>{{k, 0.0}, {k, kProbedRest}}; };
  row.probe.combine = [](const double* x, double k, double* p) {
    const double share = x[0] + x[1];
    p[0] = k * share;
    p[1] = kProbedRest * x[1] / share;
    return share > 0.0 && std::abs(p[1]) < 7.0;
  };
  return row;
}

EffectInfo make_cogging() {
  EffectInfo row = make_row(EffectId::kCogging, "cogging", PlaceKind::kJoint, EffectFamily::kTorqueOverPosition,
                            "the torque ripples with the joint's position",
                            {P("amplitude", "N m").absent_at(0).size(0.05),
                             P("periods", "1/rad").bounds(0, kUnbounded).search(1, 2000).size(0.02),
                             P("phase", "rad").as_angle().search(-100, 100).size(0.05).optional(0)});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->cogging_amplitude = p[0];
    at.joint->cogging_periods = p[1];
    at.joint->cogging_phase = p[2];
  };
  row.torque.num_columns = 2;
  row.torque.shape_from_data = true;
  row.torque.calc_columns = [](const JointSample& s, const double* shape, double* c) {
    c[0] = -std::sin(shape[0] * s.q);
    c[1] = -std::cos(shape[0] * s.q);
  };
  row.torque.make_parameters = [](const double* x, const double* shape, double* p) {
    p[0] = std::hypot(x[0], x[1]);
    p[1] = shape[0];
    p[2] = std::atan2(x[1], x[0]);
    return true;
  };
  row.periods = 1;
  row.normalise = [](double* p) {
    if (p[0] < 0.0) {
      p[0] = -p[0];
      p[2] += M_PI;
    }
    p[2] -= 2.0 * M_PI * std::floor(p[2] / (2.0 * M_PI));
  };
  return row;
}

}  // namespace

std::vector<EffectInfo> list_transmission_rows() {
  return {make_rotor(), make_elasticity(), make_backlash(), make_spring(), make_cogging()};
}

}  // namespace hrp
