// SPDX-License-Identifier: BSD-3-Clause
// Effects of a link: its mass, what it carries, what pulls at it.
#include <algorithm>
#include <cmath>

#include "common/effects/effect_rows.h"
#include "common/effects/link_law.h"

namespace hrp {
namespace {

using P = EffectParameter;

constexpr double kLever = 0.1;  // [m] of a probing mass

Vector3d get3(const double* p) { return {p[0], p[1], p[2]}; }

EffectInfo make_payload() {
  std::vector<P> parameters{P("mass", "kg").absent_at(0).bounds(0, kUnbounded).size(0.05)};
  for (const P& axis : make_axes(P("com", "m").search(-2, 2).size(0.01))) parameters.push_back(axis);
  parameters.push_back(P("inertia", "kg m^2").bounds(0, kUnbounded).search(0, 10).size(2e-4).optional(0).as_nuisance());
  EffectInfo row = make_row(EffectId::kPayload, "payload", PlaceKind::kLink, EffectFamily::kMass,
                            "an unmodelled mass is carried", std::move(parameters));
  row.apply = [](const double* p, const EffectTarget& at) {
    add_payload(p[0], at.X_LF * get3(p + 1), p[4], at.link.front());
  };
  // A mass far out turns into a fit that does not come back when another cause had a part in it.
  row.start_scales = {{1, 0.3, 0.3, 0.3, 1}, {1, 0, 0, 0, 1}, {0.3, 0.3, 0.3, 0.3, 1}, {0.3, 0, 0, 0, 1}};
  row.find_special_case = [](const double* p, double, double mass) {
    return mass > 0.0 ? SpecialCase{EffectId::kMassError, {1.0 + p[0] / mass}} : SpecialCase{};
  };
  // Masses at the link's origin and out along its axes: any mass anywhere, but for its own inertia.
  row.probe.list = [](double mass) {
    return std::vector<std::vector<double>>{
        {mass, 0, 0, 0, 0}, {mass, kLever, 0, 0, 0}, {mass, 0, kLever, 0, 0}, {mass, 0, 0, kLever, 0}};
  };
  row.probe.combine = [](const double* x, double mass, double* p) {
    const double all = x[0] + x[1] + x[2] + x[3];
    if (!(all > 0.0)) return false;
    p[0] = mass * all;
    p[4] = 0.0;
    for (int i = 1; i < 4; ++i) p[i] = std::clamp(kLever * x[i] / all, -1.0, 1.0);
    return true;
  };
  return row;
}

EffectInfo make_mass_error() {
  EffectInfo row = make_row(
      EffectId::kMassError, "mass_error", PlaceKind::kLink, EffectFamily::kMass, "the link's mass is wrong by a factor",
      {P("scale", "1").as_factor().bounds(0, kUnbounded).search(0.01, 100).size(0.02).probed_by(0.01)});
  row.apply = [](const double* p, const EffectTarget& at) {
    for (LinkInertia* part : at.link) scale_mass(p[0], part);
  };
  row.linear = row.of_whole_link = true;
  return row;
}

EffectInfo make_com_error() {
  EffectInfo row = make_row(EffectId::kComError, "com_error", PlaceKind::kLink, EffectFamily::kMass,
                            "the link's centre of mass is elsewhere",
                            make_axes(P("offset", "m").absent_at(0).search(-2, 2).size(0.005).probed_by(1e-3)));
  row.apply = [](const double* p, const EffectTarget& at) {
    for (LinkInertia* part : at.link) move_centre_of_mass(get3(p), part);
  };
  row.linear = row.vector = row.of_whole_link = true;
  return row;
}

EffectInfo make_inertia_error() {
  EffectInfo row = make_row(EffectId::kInertiaError, "inertia_error", PlaceKind::kLink, EffectFamily::kReflectedInertia,
                            "the moments of inertia are those of another spread of mass: spin after an impact is off",
                            {P("scale", "1").as_factor().bounds(0, kUnbounded).search(0.1, 10).size(0.01)});
  row.apply = [](const double* p, const EffectTarget& at) {
    for (LinkInertia* part : at.link) part->I_LLcm_L *= p[0];
  };
  row.linear = row.of_whole_link = true;
  return row;
}

EffectInfo make_external_force() {
  EffectInfo row =
      make_row(EffectId::kExternalForce, "external_force", PlaceKind::kLink, EffectFamily::kZero,
               "a constant force pulls at the link", make_axes(P("force", "N").absent_at(0).size(0.5).probed_by(0.1)));
  row.apply = [](const double* p, const EffectTarget& at) { *at.force_W += get3(p); };
  row.linear = row.vector = true;
  return row;
}

EffectInfo make_air_drag() {
  EffectInfo row =
      make_row(EffectId::kAirDrag, "air_drag", PlaceKind::kLink, EffectFamily::kSpeedLoss, "speed is lost in flight",
               {P("rate", "1/s").absent_at(0).search(-10, 10).size(0.01).internal()});
  row.apply = [](const double* p, const EffectTarget& at) { *at.drag = p[0]; };
  row.reported = false;
  return row;
}

}  // namespace

std::vector<EffectInfo> list_link_rows() {
  return {make_payload(),       make_mass_error(),     make_com_error(),
          make_inertia_error(), make_external_force(), make_air_drag()};
}

}  // namespace hrp
