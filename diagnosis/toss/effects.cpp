// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/toss/effects.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "common/effects/effect_target.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/toss/model.h"

namespace hrp::diagnosis::toss {
namespace {

const Place kGround{PlaceKind::kGround, 0, Reading::kAll}, kBody = at_link(0), kPose = at_sensor(0, Reading::kAll),
                                                           kPosition = at_sensor(0, Reading::kPosition),
                                                           kAttitude = at_sensor(0, Reading::kOrientation);

// The parameters [first, first + count) of the table, all with the same step and bounds.
struct Fitted {
  size_t first, count;
  double step, low, high;
};

TossRow make_row(EffectId id, const Place& place, const Fitted& fitted) {
  TossRow row{id, place, {}};
  for (size_t i = fitted.first; i < fitted.first + fitted.count; ++i) {
    row.parameters.push_back({&get_effect(id).parameters.at(i), fitted.step, fitted.low, fitted.high});
  }
  return row;
}

TossRow make_flying(EffectId id, const Place& place, const Fitted& fitted) {
  TossRow row = make_row(id, place, fitted);
  row.flies = true;
  return row;
}

TossRow make_friction() {
  TossRow row = make_row(EffectId::kGroundFriction, kGround, {0, 1, 0.01, 0, 3});
  row.find_nominal = [](const World& world, size_t) { return world.ground.friction; };
  row.jumps = true;
  // Sticking contacts do not depend on friction, so a slope may be zero. Tries less and more.
  row.list_starts = [](const TossProblem&, const Hypothesis&, const Effect& none) {
    Hypothesis out{none, none};
    out[0].p[0] *= 0.5;
    out[1].p[0] *= 1.5;
    return out;
  };
  return row;
}

TossRow make_restitution() {
  TossRow row = make_row(EffectId::kRestitution, kGround, {0, 1, 0.01, 0, 1});
  row.find_nominal = [](const World& world, size_t) { return world.restitution; };
  row.jumps = true;
  // Nothing bounces below a threshold speed, so a slope may be zero.
  row.list_starts = [](const TossProblem&, const Hypothesis&, const Effect& none) {
    Hypothesis out{none};
    out[0].p[0] = std::min(1.0, none.p[0] + 0.2);
    return out;
  };
  return row;
}

TossRow make_slope() {
  TossRow row = make_row(EffectId::kGroundSlope, kGround, {0, 2, 1e-3, -0.5, 0.5});
  row.find_nominal = [](const World& world, size_t i) { return i == 0 ? world.ground.roll : world.ground.pitch; };
  return row;
}

TossRow make_payload() {
  TossRow row = make_row(EffectId::kPayload, kBody, {0, 4, 1e-3, -1, 1});
  row.parameters[0].low = 0;
  row.parameters[0].high = 1e3;
  row.inside = EffectId::kComError;
  // Starts with a tenth of the body's mass, at the place that gives the fitted offset of the centre of mass.
  row.list_starts = [](const TossProblem& problem, const Hypothesis& found, const Effect& none) {
    Hypothesis out{none};
    out[0].p[0] = 0.1 * problem.nominal.body.links[0].inertia.mass;
    for (const Effect& e : found) {
      for (size_t i = 0; e.id == get_toss_row(none).inside && i < 3; ++i) out[0].p[i + 1] = 11.0 * e.p[i];
    }
    return out;
  };
  return row;
}

TossRow make_inertia() {
  TossRow row =
      make_row(get_effect_of(PlaceKind::kLink, EffectFamily::kReflectedInertia).id, kBody, {0, 1, 0.01, 0.1, 10});
  row.refused = "only impacts speak of it, and their law is not known well enough";
  row.get_measured = [](const TossProblem& problem) { return problem.inertia; };
  // Another inertia may lead to other contacts in a window, so a small step may show nothing.
  row.list_starts = [](const TossProblem&, const Hypothesis&, const Effect& none) {
    Hypothesis out{none, none, none};
    out[1].p[0] *= 0.8;
    out[2].p[0] *= 1.25;
    return out;
  };
  return row;
}

TossRow make_height() {
  TossRow row = make_row(get_effect_of(PlaceKind::kSensor, EffectFamily::kZero).id, kPosition, {2, 1, 1e-4, -1, 1});
  row.unit = "m";
  row.get_measured = [](const TossProblem& problem) { return problem.rest_height; };
  return row;
}

// Positions with a scale that is too large, or a slow clock, make the body seem to fall faster.
TossRow make_scale() {
  TossRow row = make_flying(get_effect_of(PlaceKind::kSensor, EffectFamily::kGain).id, kPosition, {0, 1, 1e-3, 0.5, 2});
  row.get_measured = [](const TossProblem& problem) { return problem.fall; };
  return row;
}

TossRow make_skew() {
  TossRow row = make_flying(EffectId::kClockSkew, kPose, {0, 1, 1e-3, -0.2, 0.2});
  row.get_measured = [](const TossProblem& problem) {
    std::optional<Measured> skew = problem.fall;
    if (!skew) return skew;
    skew->value = std::sqrt(skew->value);
    skew->std *= 0.5 / skew->value;
    skew->value -= 1.0;
    return skew;
  };
  return row;
}

std::vector<TossRow> make_rows() {
  return {make_friction(), make_restitution(), make_slope(),
          make_flying(EffectId::kComError, kBody, {0, 3, 1e-4, -1, 1}), make_payload(), make_inertia(), make_height(),
          make_scale(),
          make_row(get_effect_of(PlaceKind::kSensor, EffectFamily::kSensorGeometry).id, kAttitude, {0, 3, 1e-3, -1, 1}),
          // relative to positions, so it may be negative
          make_flying(get_late_reading().id, kAttitude, {0, 1, 2e-4, -0.1, 0.1}), make_skew(),
          make_flying(EffectId::kAirDrag, kBody, {0, 1, 0.01, -10, 10})};
}

// All parameters in the table's order; NaN (no change) for those that poses do not determine.
std::vector<double> list_values(const Effect& effect) {
  const EffectInfo& info = get_effect(effect.id);
  const TossRow& row = get_toss_row(effect);
  std::vector<double> values;
  for (const EffectParameter& p : info.parameters) values.push_back(p.required ? std::nan("") : p.value);
  for (size_t i = 0; i < effect.p.size(); ++i) {
    values[static_cast<size_t>(row.parameters[i].info - info.parameters.data())] = effect.p[i];
  }
  return values;
}

}  // namespace

const std::vector<TossRow>& list_toss_rows() {
  static const std::vector<TossRow> rows = make_rows();
  return rows;
}

const TossRow& get_toss_row(EffectId id) {
  const auto& rows = list_toss_rows();
  const auto at = std::find_if(rows.begin(), rows.end(), [id](const TossRow& row) { return row.id == id; });
  HRP_CHECK(at != rows.end(), "poses of a tossed body do not show this effect");
  return *at;
}

Effect make_neutral(const TossProblem& problem, EffectId id) {
  const TossRow& row = get_toss_row(id);
  Effect effect{id, row.place, {}};
  for (size_t i = 0; i < row.parameters.size(); ++i) {
    const double none = row.parameters[i].info->neutral;
    effect.p.push_back(row.find_nominal ? row.find_nominal(problem.nominal, i) : std::isfinite(none) ? none : 0.0);
  }
  return effect;
}

bool has_effect(const Hypothesis& hypothesis, EffectId id) {
  return std::any_of(hypothesis.begin(), hypothesis.end(), [&](const Effect& e) { return e.id == id; });
}

Hypothesis list_starts(const TossProblem& problem, const Hypothesis& found, EffectId id) {
  Effect none = make_neutral(problem, id);
  const TossRow& row = get_toss_row(id);
  if (const auto measured = row.get_measured ? row.get_measured(problem) : std::nullopt) {
    none.p[0] = std::clamp(measured->value, row.parameters[0].low, row.parameters[0].high);
    return {none};
  }
  return row.list_starts ? row.list_starts(problem, found, none) : Hypothesis{none};
}

TossModel make_toss_model(const TossProblem& problem, const Hypothesis& hypothesis) {
  TossModel model{problem.nominal, {}};
  World& world = model.world;
  SensorErrors position, attitude;
  ContactSpec contact;
  contact.restitution = world.restitution;
  EffectTarget target;
  target.link = {&world.body.links[0].inertia};
  target.ground = &world.ground;
  target.contact = &contact;
  target.drag = &world.drag;
  for (const Effect& e : hypothesis) {
    const std::vector<double> values = list_values(e);
    for (SensorErrors* sensor : {&position, &attitude}) {
      if (e.place == kPosition && sensor == &attitude) continue;
      if (e.place == kAttitude && sensor == &position) continue;
      if (e.place.kind != PlaceKind::kSensor && sensor == &attitude) continue;  // once
      target.sensor = sensor;
      get_effect(e.id).apply(values.data(), target);
    }
  }
  world.restitution = contact.restitution;
  model.sensor = {position.scale.x(), position.bias, make_rotation_from_rpy(attitude.misalignment), attitude.delay,
                  attitude.clock_skew};
  return model;
}

}  // namespace hrp::diagnosis::toss
