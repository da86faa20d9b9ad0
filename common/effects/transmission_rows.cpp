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

void set_elastic(double stiffness, double damping, double inertia, JointLaws* laws) {
  laws->elastic = true;
  laws->stiffness = stiffness;
  laws->damping = damping;
  if (inertia > 0.0) laws->motor_inertia = inertia;
}

EffectInfo make_rotor() {
  EffectInfo row = make_row(EffectId::kRotorInertia, "rotor_inertia", PlaceKind::kJoint,
                            EffectFamily::kReflectedInertia, "the rotor's reflected inertia is missing",
                            {P("inertia", "kg m^2").absent_at(0).bounds(0, kUnbounded).size(0.01)});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->motor_inertia += p[0]; };
  row.torque = {1, {}, false, false, [](const JointSample& s, const double*, double* c) { c[0] = s.a; },
                [](const double* x, const double*, double* p) { return p[0] = x[0], x[0] > 0.0; }};
  row.linear = true, row.rotor = 0;
  return row;
}

EffectInfo make_elasticity() {
  EffectInfo row =
      make_row(EffectId::kElasticity, "joint_elasticity", PlaceKind::kJoint, EffectFamily::kPlay,
               "the transmission is elastic",
               {P("stiffness", "N m/rad").absent_at(kUnbounded).bounds(1e-3, kUnbounded).search(1, 1e7).size(100),
                P("damping", "N m s/rad").bounds(0, kUnbounded).search(0, 1e4).size(0.2),
                P("rotor_inertia", "kg m^2").bounds(1e-9, kUnbounded).search(1e-4, 1e3).size(0.02)});
  row.apply = [](const double* p, const EffectTarget& at) { set_elastic(p[0], p[1], p[2], at.joint); };
  row.flexible = true, row.smooth = false, row.rotor = 2;
  return row;
}

EffectInfo make_backlash() {
  EffectInfo row = make_row(
      EffectId::kBacklash, "backlash", PlaceKind::kJoint, EffectFamily::kPlay, "the transmission has play",
      {P("gap", "rad").absent_at(0).bounds(0, 1).size(0.002).as_walked(),
       P("stiffness", "N m/rad").bounds(1e-3, kUnbounded).search(10, 1e6).size(1000).optional(kToothStiffness)
           .as_nuisance().as_walked(),
       P("damping", "N m s/rad").bounds(0, kUnbounded).search(0, 1e3).size(0.5).optional(kToothDamping)
           .as_nuisance().as_walked(),
       P("rotor_inertia", "kg m^2").bounds(0, kUnbounded).search(1e-4, 1e3).size(0.02).optional(0).as_nuisance()});
  row.apply = [](const double* p, const EffectTarget& at) {
    if (!at.joint->elastic) set_elastic(p[1], p[2], p[3], at.joint);
    at.joint->gap = p[0];
  };
  row.flexible = true, row.smooth = false, row.rotor = 3;
  return row;
}

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
  row.torque = {2, {}, false, false, [](const JointSample& s, const double*, double* c) { c[0] = s.q, c[1] = 1.0; },
                [](const double* x, const double*, double* p) {
                  p[0] = x[0], p[1] = -x[1] / x[0];
                  return x[0] > 0.0 && std::abs(x[1] / x[0]) < 7.0;
                }};
  row.linear = true;
  return row;
}

EffectInfo make_cogging() {
  EffectInfo row = make_row(EffectId::kCogging, "cogging", PlaceKind::kJoint, EffectFamily::kTorqueOverPosition,
                            "the torque ripples with the joint's position",
                            {P("amplitude", "N m").absent_at(0).size(0.05),
                             P("periods", "1/rad").bounds(0, kUnbounded).search(1, 2000).size(0.02),
                             P("phase", "rad").search(-100, 100).size(0.05).optional(0)});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->cogging_amplitude = p[0];
    at.joint->cogging_periods = p[1];
    at.joint->cogging_phase = p[2];
  };
  row.torque.num_columns = 2;
  row.torque.shape_from_data = true;
  row.torque.calc_columns = [](const JointSample& s, const double* shape, double* c) {
    c[0] = -std::sin(shape[0] * s.q), c[1] = -std::cos(shape[0] * s.q);
  };
  row.torque.make_parameters = [](const double* x, const double* shape, double* p) {
    p[0] = std::hypot(x[0], x[1]), p[1] = shape[0], p[2] = std::atan2(x[1], x[0]);
    return true;
  };
  return row;
}

}  // namespace

std::vector<EffectInfo> list_transmission_rows() {
  return {make_rotor(), make_elasticity(), make_backlash(), make_spring(), make_cogging()};
}

}  // namespace hrp
