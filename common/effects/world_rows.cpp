// SPDX-License-Identifier: BSD-3-Clause
// Effects of feet and of the ground.
#include <cmath>

#include "common/effects/effect_rows.h"

namespace hrp {
namespace {

using P = EffectParameter;

const double kNan = std::nan("");

// What is not stated stays as it is.
void set(double value, double* field) {
  if (std::isfinite(value)) *field = value;
}

P make_stiffness(const char* name, const char* unit) {
  return P(name, unit).absent_at(kUnbounded).bounds(1e-9, kUnbounded).size(100).optional(kNan);
}

P make_damping(const char* name, const char* unit) {
  return P(name, unit).bounds(0, kUnbounded).size(1).optional(kNan);
}

// A bush between force sensor and sole: slide z, then roll, then pitch about the foot's axes.
std::vector<P> list_bush_parameters() {
  std::vector<P> all{make_stiffness("kz", "N/m"),
                     make_damping("cz", "N s/m"),
                     make_stiffness("k_roll", "N m/rad"),
                     make_damping("c_roll", "N m s/rad"),
                     make_stiffness("k_pitch", "N m/rad"),
                     make_damping("c_pitch", "N m s/rad"),
                     P("offset_roll", "N m").size(0.1).optional(kNan),
                     P("offset_pitch", "N m").size(0.1).optional(kNan)};
  for (const P& axis : make_axes(P("center", "m").search(-1, 1).size(1e-3).optional(kNan))) all.push_back(axis);
  return all;
}

void apply_bush(const double* p, const EffectTarget& at) {
  FootBushSpec& bush = *at.bush;
  double* fields[] = {&bush.kz,      &bush.cz,      &bush.k_roll,      &bush.c_roll,
                      &bush.k_pitch, &bush.c_pitch, &bush.offset_roll, &bush.offset_pitch};
  for (double* field : fields) set(*p++, field);
  if (std::isfinite(p[0])) bush.center = Vector3d(p[0], p[1], p[2]);
}

EffectInfo make_foot_compliance() {
  EffectInfo row = make_row(EffectId::kFootCompliance, "foot_compliance", PlaceKind::kFoot, EffectFamily::kPlay,
                            "the sole gives below the force sensor", list_bush_parameters());
  row.apply = &apply_bush;
  return row;
}

EffectInfo make_foot_hardening() {
  std::vector<P> parameters = list_bush_parameters();
  parameters.push_back(
      P("hardening_angle", "rad").absent_at(kUnbounded).bounds(1e-9, kUnbounded).size(0.01).optional(kNan));
  EffectInfo row = make_row(EffectId::kFootHardening, "foot_hardening", PlaceKind::kFoot, EffectFamily::kPlay,
                            "the sole gives below the force sensor, and hardens as it does", std::move(parameters));
  row.apply = [](const double* p, const EffectTarget& at) {
    apply_bush(p, at);
    set(p[11], &at.bush->hardening_angle);
  };
  return row;
}

EffectInfo make_ground_slope() {
  EffectInfo row = make_row(
      EffectId::kGroundSlope, "ground_slope", PlaceKind::kGround, EffectFamily::kZero, "the ground is not level",
      {P("roll", "rad").absent_at(0).bounds(-1.2, 1.2).search(-0.5, 0.5).size(1e-3).optional(kNan),
       P("pitch", "rad").absent_at(0).bounds(-1.2, 1.2).search(-0.5, 0.5).size(1e-3).optional(kNan)});
  row.apply = [](const double* p, const EffectTarget& at) {
    set(p[0], &at.ground->roll);
    set(p[1], &at.ground->pitch);
  };
  row.vector = true;
  return row;
}

EffectInfo make_ground_friction() {
  EffectInfo row =
      make_row(EffectId::kGroundFriction, "ground_friction", PlaceKind::kGround, EffectFamily::kContact,
               "the ground's friction differs from the model's: speed along the ground is lost at another rate",
               {P("coefficient", "1").bounds(0, kUnbounded).search(0, 3).size(0.01)});
  row.apply = [](const double* p, const EffectTarget& at) { at.ground->friction = p[0]; };
  return row;
}

EffectInfo make_restitution() {
  EffectInfo row = make_row(EffectId::kRestitution, "restitution", PlaceKind::kGround, EffectFamily::kContact,
                            "the body bounces: of the speed at which a point strikes, this share comes back",
                            {P("coefficient", "1").bounds(0, 1).size(0.01)});
  // Of the impulse model: there the coefficient is what comes out, not what a damper makes of it.
  row.apply = [](const double* p, const EffectTarget& at) {
    at.contact->restitution = p[0];
    at.contact->model = "impulse";
  };
  return row;
}

// The base stands turned by roll, then pitch about fixed axes, and the model does not know: what it takes for down is
// turned the other way.
EffectInfo make_base_tilt() {
  EffectInfo row =
      make_row(EffectId::kNamed, "base_tilt", PlaceKind::kNone, EffectFamily::kZero,
               "the base is tilted: gravity pulls in another direction than the model has it",
               {P("roll", "rad").absent_at(0).bounds(-1.2, 1.2).search(-0.5, 0.5).size(1e-3).optional(0),
                P("pitch", "rad").absent_at(0).bounds(-1.2, 1.2).search(-0.5, 0.5).size(1e-3).optional(0)});
  row.apply = [](const double* p, const EffectTarget& at) {
    *at.gravity_W = make_rotation_from_rpy({p[0], p[1], 0.0}).transpose() * *at.gravity_W;
  };
  row.vector = true;
  return row;
}

// Springs, counterweights or a controller outside of the log carry a share of every link's weight. On a fixed base that
// is gravity smaller by this share: inverse dynamics is linear in gravity.
EffectInfo make_gravity_compensation() {
  EffectInfo row =
      make_row(EffectId::kNamed, "gravity_compensation", PlaceKind::kNone, EffectFamily::kTorqueOverPosition,
               "something else carries the links: a controller, springs or counterweights; or the robot lies flat",
               {P("share", "1").absent_at(0).bounds(0, 1).search(0, 1).size(0.01)});
  row.apply = [](const double* p, const EffectTarget& at) { *at.gravity_W *= 1.0 - p[0]; };
  return row;
}

}  // namespace

std::vector<EffectInfo> list_world_rows() {
  return {make_foot_compliance(), make_foot_hardening(), make_ground_slope(),        make_ground_friction(),
          make_restitution(),     make_base_tilt(),      make_gravity_compensation()};
}

}  // namespace hrp
