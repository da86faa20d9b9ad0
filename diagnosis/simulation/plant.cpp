// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/simulation/plant.h"

#include <algorithm>

#include "common/effects/effect_target.h"
#include "diagnosis/model/nominal.h"

namespace hrp::diagnosis {
namespace {

// The parts of a plant that an effect changes. `force_W`: by link, at its centre of mass.
EffectTarget find_target(const Effect& effect, Plant* plant, std::vector<Vector3d>* force_W, Vector3d* gravity_W) {
  EffectTarget target;
  const auto place = static_cast<size_t>(effect.place.index);
  target.timing = &plant->timing;
  target.gravity_W = gravity_W;
  switch (effect.place.kind) {
    case PlaceKind::kJoint: target.joint = &plant->laws[place]; break;
    case PlaceKind::kLink:
      target.link = {&plant->tree.links[place].inertia};
      target.force_W = &(*force_W)[place];
      break;
    case PlaceKind::kSensor: target.sensor = &plant->faults[static_cast<size_t>(get_signal(effect.place))]; break;
    default: break;
  }
  return target;
}

void apply(const Effect& effect, Plant* plant, std::vector<Vector3d>* force_W, Vector3d* gravity_W) {
  std::vector<double> values = effect.p;
  values.resize(get_effect(effect.id).parameters.size(), std::nan(""));
  get_effect(effect.id).apply(values.data(), find_target(effect, plant, force_W, gravity_W));
}

}  // namespace

const std::vector<EffectParameter>& list_infos(EffectId id) {
  return get_effect(id).place == PlaceKind::kSensor ? list_scalar_parameters(id) : get_effect(id).parameters;
}

std::string get_place_text(const Experiment& e, const Effect& effect) {
  switch (effect.place.kind) {
    case PlaceKind::kJoint: return e.robot.tree.joint(effect.place.index).name;
    case PlaceKind::kLink: return e.robot.tree.links[static_cast<size_t>(effect.place.index)].name;
    case PlaceKind::kSensor:
      return e.signal_name(effect.place.index, static_cast<Quantity>(get_signal(effect.place) % kQuantities));
    default: return "";
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
  for (const Effect& effect : hypothesis) set.push_back({effect.id, effect.place});
  std::sort(set.begin(), set.end());
  return set;
}

bool contains(const Hypothesis& hypothesis, EffectId id, const Place& place) {
  return std::any_of(hypothesis.begin(), hypothesis.end(),
                     [&](const Effect& e) { return e.id == id && e.place == place; });
}

bool is_timing_row(const EffectInfo& row) { return row.family == EffectFamily::kTiming && !row.reported; }
bool is_timing(const Effect& effect) { return is_timing_row(get_effect(effect.id)); }

Plant make_plant(const Experiment& e, const Hypothesis& hypothesis) {
  Plant plant;
  NominalRobot nominal = make_nominal(e);
  plant.tree = std::move(nominal.tree);
  plant.laws = std::move(nominal.laws);
  std::vector<Vector3d> force_W = std::move(nominal.force_W);
  force_W.resize(plant.tree.links.size(), Vector3d::Zero());
  const auto n = plant.laws.size();
  plant.faults.resize(n * kQuantities);
  plant.effort_driven = is_effort_driven(e);
  Vector3d gravity_W = e.scenario.gravity_W;
  for (const Effect& effect : hypothesis) apply(effect, &plant, &force_W, &gravity_W);
  for (size_t j = 0; j < n; ++j) {
    const JointLaws& laws = plant.laws[j];
    plant.rotor.push_back(laws.elastic ? 0.0 : std::max(0.0, laws.motor_inertia));
    // the whole inertia is on the motor side
    if (laws.elastic) plant.tree.joint(static_cast<int>(j)).rotor_inertia = 0.0;
  }
  for (size_t link = 0; link < force_W.size(); ++link) {
    if (!force_W[link].isZero())
      plant.forces.push_back({static_cast<int>(link), plant.tree.links[link].inertia.p_LLcm_L, force_W[link]});
  }
  plant.model = std::make_shared<const Model>(plant.tree, gravity_W);
  return plant;
}

double get_effort_delay(const Plant& plant, int joint) {
  return plant.faults[static_cast<size_t>(get_signal(at_sensor(joint, Reading::kEffort)))].delay;
}

Plant add_by_hand(Plant plant, const RecordingSpec& recording) {
  for (const SteadyForce& pull : list_pulls(recording, plant.tree)) plant.forces.push_back(pull);
  if (recording.loads.empty()) return plant;
  add_loads(recording, &plant.tree);
  plant.model = std::make_shared<const Model>(plant.tree, plant.model->gravity_W());
  return plant;
}

Plant make_plant(const Experiment& e, const Hypothesis& hypothesis, const RecordingSpec& recording) {
  return add_by_hand(make_plant(e, hypothesis), recording);
}

}  // namespace hrp::diagnosis
