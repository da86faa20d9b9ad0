// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/standing/terms.h"

#include <algorithm>
#include <cmath>

#include "common/effects/effect_target.h"
#include "diagnosis/standing/effects.h"

namespace hrp::diagnosis::standing {
namespace {

// Terms that the experiment states about a joint's drive.
JointTerms make_stated_terms(const JointLaws& laws) {
  JointTerms t;
  t.laws = laws;
  if (laws.stribeck_velocity > 0) t.excess = std::max(0.0, laws.static_level - laws.coulomb);
  t.moment = -laws.spring_stiffness * laws.spring_rest;
  t.cogging_sin = laws.cogging_amplitude * std::cos(laws.cogging_phase);
  t.cogging_cos = laws.cogging_amplitude * std::sin(laws.cogging_phase);
  if (laws.elastic) t.compliance = 1 / laws.stiffness;
  return t;
}

// Values in the table's order, fitted ones first. A single value of a sensor applies to all of its axes.
std::vector<double> list_values(const Effect& e) {
  std::vector<double> values;
  for (const EffectParameter& p : get_effect(e.id).parameters) {
    const size_t i = values.size();
    const bool axis = e.place.kind == PlaceKind::kSensor;
    values.push_back(i < e.p.size() ? e.p[i] : axis ? e.p.back() : p.value);
  }
  return values;
}

}  // namespace

std::vector<SensorErrors*> Terms::find_sensors(const Effect& e) {
  const auto i = static_cast<size_t>(e.place.index);
  switch (e.place.reading) {
    case Reading::kPosition: return {&joints[i].position};
    case Reading::kVelocity: return {&joints[i].velocity};
    case Reading::kEffort: return {&joints[i].effort};
    case Reading::kWrench: return {&wrenches[i].force, &wrenches[i].torque};
    case Reading::kForce: return {&wrenches[i].force};
    case Reading::kTorque: return {&wrenches[i].torque};
    case Reading::kImu: return {&imu.attitude, &imu.gyro, &imu.accelerometer};
    case Reading::kOrientation: return {&imu.attitude};
    case Reading::kAngularVelocity: return {&imu.gyro};
    case Reading::kAcceleration: return {&imu.accelerometer};
    case Reading::kAll: break;
  }
  return {};
}

void Terms::add(const Effect& e) {
  const auto place = static_cast<size_t>(e.place.index);
  StandTarget own;
  EffectTarget target;
  if (is_joint(e)) {
    own.joint = &joints[place];
    target.joint = &own.joint->laws;
  }
  if (is_link(e)) {
    own.link = &tree.links[place].inertia;
    target.link = {own.link};
    target.force_W = &force_W[place];
  }
  if (is_foot(e)) own.feet = &feet;
  target.ground = &ground;
  if (get_row(e).apply) return get_row(e).apply(e.p, own);
  const std::vector<double> values = list_values(e);
  if (e.place.kind != PlaceKind::kSensor) return get_effect(e.id).apply(values.data(), target);
  for (SensorErrors* sensor : find_sensors(e)) {
    target.sensor = sensor;
    get_effect(e.id).apply(values.data(), target);
  }
}

Terms::Terms(const StandProblem& problem, const Hypothesis& hypothesis)
    : joints(static_cast<size_t>(problem.tree.num_joints())),
      wrenches(problem.feet.size()),
      feet(problem.feet.size()),
      tree(problem.tree),
      force_W(problem.force_W) {
  ground.friction = 0;
  force_W.resize(problem.tree.links.size(), Vector3d::Zero());
  for (size_t j = 0; j < problem.laws.size(); ++j) joints[j] = make_stated_terms(problem.laws[j]);
  for (const Effect& e : hypothesis) add(e);
}

}  // namespace hrp::diagnosis::standing
