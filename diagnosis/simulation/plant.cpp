// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/simulation/plant.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace hrp::diagnosis {
namespace {

void apply_link_effect(const Effect& effect, Plant* plant) {
  LinkInertia& inertia = plant->tree.links[static_cast<size_t>(effect.place)].inertia;
  const std::vector<double>& p = effect.p;
  if (effect.id == EffectId::kMassError) {
    inertia.mass *= p[0];
    inertia.I_LLcm_L *= p[0];
  } else if (effect.id == EffectId::kComError) {
    inertia.p_LLcm_L += Vector3d(p[0], p[1], p[2]);
  } else if (effect.id == EffectId::kPayload) {  // a mass with the same inertia about every axis
    const Vector3d at(p[1], p[2], p[3]);
    const double mass = inertia.mass + p[0];
    if (!(mass > 0.0)) return;
    const Vector3d com = (inertia.mass * inertia.p_LLcm_L + p[0] * at) / mass;
    const auto steiner = [](double m, const Vector3d& r) -> Matrix3d {
      return m * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
    };
    inertia.I_LLcm_L += steiner(inertia.mass, inertia.p_LLcm_L - com) + steiner(p[0], at - com);
    inertia.I_LLcm_L += p[4] * Matrix3d::Identity();
    inertia.mass = mass;
    inertia.p_LLcm_L = com;
  } else {
    if (plant->force_W.empty()) plant->force_W.assign(plant->tree.links.size(), Vector3d::Zero());
    plant->force_W[static_cast<size_t>(effect.place)] += Vector3d(p[0], p[1], p[2]);
  }
}

void apply_transmission(const Effect& effect, JointLaws* laws) {
  laws->elastic = true;
  const bool gap = effect.id == EffectId::kBacklash;
  laws->gap = gap ? effect.p[0] : laws->gap;
  laws->stiffness = effect.p[gap ? 1 : 0];
  laws->damping = effect.p[gap ? 2 : 1];
  laws->motor_inertia = effect.p[gap ? 3 : 2];
}

void apply_joint_effect(const Effect& effect, Plant* plant) {
  JointLaws& laws = plant->laws[static_cast<size_t>(effect.place)];
  const std::vector<double>& p = effect.p;
  switch (effect.id) {
    case EffectId::kViscous:
      laws.viscous += p[0];
      break;
    case EffectId::kCoulomb:
      laws.coulomb += p[0], laws.asymmetry = p[1], plant->presliding[static_cast<size_t>(effect.place)] = p[2];
      break;
    case EffectId::kStribeck:
      laws.coulomb += p[0], laws.static_level = p[1], laws.stribeck_velocity = p[2], laws.viscous += p[3];
      plant->presliding[static_cast<size_t>(effect.place)] = p[4];
      break;
    case EffectId::kLoadFriction:
      laws.load_ratio += p[0], plant->presliding[static_cast<size_t>(effect.place)] = p[1];
      break;
    case EffectId::kRotorInertia:
      plant->rotor[static_cast<size_t>(effect.place)] += p[0];
      break;
    case EffectId::kElasticity:
    case EffectId::kBacklash:
      apply_transmission(effect, &laws);
      break;
    case EffectId::kTorqueConstant:
      laws.torque_scale = p[0];
      break;
    case EffectId::kSaturation:
      laws.saturation = p[0];
      break;
    case EffectId::kLag:
      laws.lag = p[0];
      break;
    case EffectId::kDelay:
      laws.command_delay = p[0];
      break;
    case EffectId::kSpring:
      laws.spring_stiffness = p[0], laws.spring_rest = p[1];
      break;
    case EffectId::kCogging:
      laws.cogging_amplitude = p[0], laws.cogging_periods = p[1], laws.cogging_phase = p[2];
      break;
    case EffectId::kHysteresis:
      laws.hysteresis_stiffness = p[0], laws.hysteresis_yield = p[1];
      break;
    case EffectId::kJointOffset:
      laws.joint_offset = p[0];
      break;
    case EffectId::kDriveTiming:
      laws.command_delay += p[0];
      break;
    default:
      break;
  }
}

void apply(const Effect& effect, Plant* plant) {
  switch (find_place_kind(effect.id)) {
    case PlaceKind::kJoint:
      apply_joint_effect(effect, plant);
      break;
    case PlaceKind::kLink:
      apply_link_effect(effect, plant);
      break;
    case PlaceKind::kSensor: {
      SignalFault& fault = plant->faults[static_cast<size_t>(effect.place)];
      if (effect.id == EffectId::kSensorBias) fault.bias = effect.p[0];
      if (effect.id == EffectId::kSensorScale) fault.scale = effect.p[0];
      if (effect.id == EffectId::kSensorDelay) fault.delay = effect.p[0];
      break;
    }
    case PlaceKind::kNone:
      if (effect.id == EffectId::kTiming)
        plant->command_shift = effect.p[0], plant->rate_lag = effect.p[1];
      else
        plant->clock_skew = effect.p[0];
      break;
    default:
      break;
  }
}

}  // namespace

PlaceKind find_place_kind(EffectId id) { return id == EffectId::kClockSkew ? PlaceKind::kNone : get_effect(id).place; }

const std::vector<EffectParameter>& list_infos(EffectId id) {
  return find_place_kind(id) == PlaceKind::kSensor ? list_scalar_parameters(id) : get_effect(id).parameters;
}

std::string get_place_text(const Experiment& e, const Effect& effect) {
  switch (find_place_kind(effect.id)) {
    case PlaceKind::kJoint:
      return e.robot.tree.joint(effect.place).name;
    case PlaceKind::kLink:
      return e.robot.tree.links[static_cast<size_t>(effect.place)].name;
    case PlaceKind::kSensor:
      return e.signal_name(effect.place / 3, static_cast<Quantity>(effect.place % 3));
    default:
      return "";
  }
}

std::string get_label(const Experiment& e, const Effect& effect) {
  const std::string place = get_place_text(e, effect);
  return get_effect(effect.id).name + (place.empty() ? "" : "@" + place);
}

std::string get_label(const Experiment& e, const Hypothesis& hypothesis) {
  if (hypothesis.empty()) return "nothing";
  std::string text;
  for (const Effect& effect : hypothesis) text += (text.empty() ? "" : " + ") + get_label(e, effect);
  return text;
}

EffectSet make_set(const Hypothesis& hypothesis) {
  EffectSet set;
  for (const Effect& effect : hypothesis) set.push_back({static_cast<int>(effect.id), effect.place});
  std::sort(set.begin(), set.end());
  return set;
}

bool contains(const Hypothesis& hypothesis, EffectId id, int place) {
  return std::any_of(hypothesis.begin(), hypothesis.end(),
                     [&](const Effect& e) { return e.id == id && e.place == place; });
}

bool is_timing(const Effect& effect) { return effect.id == EffectId::kTiming || effect.id == EffectId::kDriveTiming; }

Plant make_plant(const Experiment& e, const Hypothesis& hypothesis) {
  Plant plant;
  plant.tree = e.robot.tree;
  const int n = plant.tree.num_joints();
  plant.laws.resize(static_cast<size_t>(n));
  plant.rotor.assign(static_cast<size_t>(n), 0.0);
  plant.presliding.assign(static_cast<size_t>(n), kPresliding);
  plant.faults.resize(static_cast<size_t>(n) * kQuantities);
  plant.effort_driven = e.scenario.drive == "effort";
  for (int j = 0; j < n; ++j) {
    const JointSpec& joint = plant.tree.joint(j);
    JointLaws& laws = plant.laws[static_cast<size_t>(j)];
    const auto it = e.scenario.servo_joints.find(joint.name);
    const ServoGains& gains = it == e.scenario.servo_joints.end() ? e.scenario.servo_default : it->second;
    if (joint.actuated && !plant.effort_driven)
      laws.kp = gains.kp, laws.kd = gains.kd, laws.effort_limit = gains.effort_limit;
    laws.viscous = joint.viscous_friction;
    laws.coulomb = joint.coulomb_friction;
  }
  for (const Effect& effect : hypothesis) apply(effect, &plant);
  for (double& rotor : plant.rotor) {
    if (rotor < 0.0) rotor = 0.0;
  }
  plant.model = std::make_shared<const Model>(plant.tree, e.scenario.gravity_W);
  return plant;
}

}  // namespace hrp::diagnosis
