// SPDX-License-Identifier: BSD-3-Clause
// Effects that brake a joint's motor side.
#include <algorithm>
#include <cmath>

#include "common/effects/effect_rows.h"

namespace hrp {
namespace {

using P = EffectParameter;

bool take_positive(const double* x, const double*, double* p) {
  p[0] = x[0];
  return x[0] > 0.0;
}

P make_presliding() {
  return P("presliding", "rad").bounds(1e-6, 0.1).size(kPresliding).optional(kPresliding).as_nuisance().as_scanned();
}

// NaN: not stated.
void set_presliding(double value, JointLaws* laws) {
  if (std::isfinite(value)) {
    laws->presliding = value;
    laws->bends = true;
  }
}

// Adds levels [N m] in motion and at rest to the friction that is there.
void add_friction(double moving, double at_rest, JointLaws* laws) {
  laws->static_level = std::max(laws->static_level, laws->coulomb) + at_rest;
  laws->coulomb += moving;
}

EffectInfo make_viscous() {
  EffectInfo row = make_row(EffectId::kViscous, "viscous_friction", PlaceKind::kJoint, EffectFamily::kSpeedLoss,
                            "viscous friction brakes in proportion to speed",
                            {P("coefficient", "N m s/rad").absent_at(0).bounds(0, kUnbounded).size(0.1)});
  row.apply = [](const double* p, const EffectTarget& at) { at.joint->viscous += p[0]; };
  row.torque.num_columns = 1;
  row.torque.calc_columns = [](const JointSample& s, const double*, double* c) { c[0] = s.v; };
  row.torque.make_parameters = &take_positive;
  row.linear = true;
  return row;
}

EffectInfo make_coulomb() {
  EffectInfo row =
      make_row(EffectId::kCoulomb, "coulomb_friction", PlaceKind::kJoint, EffectFamily::kDryFriction,
               "dry friction of constant level",
               {P("level", "N m").absent_at(0).bounds(0, kUnbounded).size(0.1),
                P("asymmetry", "1").bounds(-1, 1).size(0.02).optional(0).of_direction(), make_presliding()});
  row.apply = [](const double* p, const EffectTarget& at) {
    add_friction(p[0], p[0], at.joint);
    at.joint->asymmetry += p[1];
    set_presliding(p[2], at.joint);
  };
  row.torque.num_columns = 1;
  row.torque.calc_columns = [](const JointSample& s, const double*, double* c) { c[0] = s.direction; };
  row.torque.make_parameters = [](const double* x, const double*, double* p) {
    p[0] = x[0];
    p[1] = 0.0;
    p[2] = kPresliding;
    return x[0] > 0.0;
  };
  row.linear = row.dry = row.sticks = true;
  row.smooth = false;
  return row;
}

// A curve with next to no dry part is viscous friction, one that hardly falls is Coulomb's.
SpecialCase find_plain_friction(const double* p, double speed, double) {
  constexpr double kWeak = 0.05;  // of friction: such a part may be no part
  const double viscous = p[3] * speed;
  if (p[1] < kWeak * viscous) return {EffectId::kViscous, {p[3]}};
  if (p[1] - p[0] < kWeak * p[1] && viscous < kWeak * p[1]) return {EffectId::kCoulomb, {p[1], 0.0, p[4]}};
  return {};
}

EffectInfo make_stribeck() {
  EffectInfo row = make_row(EffectId::kStribeck, "stribeck_friction", PlaceKind::kJoint, EffectFamily::kDryFriction,
                            "dry friction that is larger at rest than in motion (Stribeck)",
                            {P("coulomb", "N m").absent_at(0).bounds(0, kUnbounded).size(0.1),
                             P("static", "N m").bounds(0, kUnbounded).size(0.1).at_least(0),
                             P("stribeck_velocity", "rad/s")
                                 .bounds(1e-6, kUnbounded)
                                 .search(5e-3, 10)
                                 .size(0.02)
                                 .starts({}, {0.015, 0.04, 0.1, 0.25}),
                             P("viscous", "N m s/rad").bounds(0, kUnbounded).size(0.1).optional(0), make_presliding()});
  row.apply = [](const double* p, const EffectTarget& at) {
    JointLaws& laws = *at.joint;
    add_friction(p[0], std::max(p[0], p[1]), &laws);
    laws.stribeck_velocity = p[2];
    laws.viscous += p[3];
    set_presliding(p[4], &laws);
  };
  row.torque.num_columns = 3;
  row.torque.shapes = {{0.02}, {0.05}, {0.12}, {0.3}};  // [rad/s]
  row.torque.calc_columns = [](const JointSample& s, const double* shape, double* c) {
    c[0] = s.direction;
    c[1] = s.direction * std::exp(-std::pow(s.v / shape[0], 2));
    c[2] = s.v;
  };
  // What is smoothed over a turn hides the bump there, or turns it over: then it starts from somewhat above the level.
  row.torque.make_parameters = [](const double* x, const double* shape, double* p) {
    p[0] = x[0];
    p[1] = std::max(x[0] + x[1], 1.3 * x[0]);
    p[2] = shape[0];
    p[3] = std::max(0.0, x[2]);
    p[4] = kPresliding;
    return x[0] > 0.0;
  };
  row.dry = row.sticks = row.always_shows = true;
  row.smooth = false;
  row.parts = {{EffectId::kCoulomb, {0, -1, 4}}, {EffectId::kViscous, {3}}};
  row.find_special_case = &find_plain_friction;
  return row;
}

EffectInfo make_load_friction() {
  EffectInfo row = make_row(EffectId::kLoadFriction, "load_dependent_friction", PlaceKind::kJoint,
                            EffectFamily::kDryFriction, "dry friction that grows with the load",
                            {P("ratio", "1").absent_at(0).bounds(0, 1).size(0.02), make_presliding()});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->load_ratio += p[0];
    set_presliding(p[1], at.joint);
  };
  row.torque.num_columns = 1;
  row.torque.calc_columns = [](const JointSample& s, const double*, double* c) {
    c[0] = s.direction * std::abs(s.effort);
  };
  row.torque.make_parameters = [](const double* x, const double*, double* p) {
    p[0] = x[0];
    p[1] = kPresliding;
    return x[0] > 0.0;
  };
  row.linear = row.sticks = true;
  row.smooth = false;
  return row;
}

// Not proposed by searches in simulation: a gear shows along the recorded motion, in the torque of inverse dynamics.
EffectInfo make_backdriving() {
  EffectInfo row = make_row(EffectId::kNamed, "backdriving_friction", PlaceKind::kJoint, EffectFamily::kDryFriction,
                            "a gear that loses more when the load turns it than when the motor does",
                            {P("ratio", "1").absent_at(0).bounds(0, 0.97).size(0.02), make_presliding()});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->backdriven = p[0];
    set_presliding(p[1], at.joint);
  };
  row.sticks = true;
  row.smooth = false;
  return row;
}

EffectInfo make_hysteresis() {
  EffectInfo row =
      make_row(EffectId::kHysteresis, "hysteresis", PlaceKind::kJoint, EffectFamily::kPlay,
               "friction with memory acts like a yielding spring",
               {P("stiffness", "N m/rad").absent_at(0).bounds(0, kUnbounded).size(1),
                P("yield_angle", "rad").bounds(1e-9, kUnbounded).search(1e-4, 10).size(0.005).starts({0.3, 1, 3})});
  row.apply = [](const double* p, const EffectTarget& at) {
    at.joint->hysteresis_stiffness = p[0];
    at.joint->hysteresis_yield = p[1];
  };
  row.torque.shapes = {{0.003}, {0.01}, {0.03}, {0.1}, {0.3}};  // [rad]
  row.torque.advance = [](double z, double step, const double* shape) {
    const int parts = 1 + static_cast<int>(std::abs(step) / shape[0] / 0.2);
    for (int i = 0; i < parts; ++i) z += calc_hysteresis_rate_factor(z, step) * step / parts / shape[0];
    return z;
  };
  row.torque.make_parameters = [](const double* x, const double* shape, double* p) {
    p[0] = x[0] / shape[0];
    p[1] = shape[0];
    return x[0] > 0.0;
  };
  row.smooth = false;
  return row;
}

}  // namespace

std::vector<EffectInfo> list_friction_rows() {
  return {make_viscous(), make_coulomb(), make_stribeck(), make_load_friction(), make_backdriving(), make_hysteresis()};
}

}  // namespace hrp
