// SPDX-License-Identifier: BSD-3-Clause
// What is assumed to be real: the experiment's nominal model plus a list of effects with parameters.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/effects/effect_target.h"
#include "common/multibody/model.h"
#include "common/effects/joint_law.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/model/effect.h"
#include "servers/dynamics/link_effects.h"

namespace hrp::diagnosis {

// Values of an effect are in this order here. Of the readings of a joint, one number each, a sensor's fault has its first axis only.
const std::vector<EffectParameter>& list_infos(EffectId id);

std::string get_place_text(const Experiment& e, const Effect& effect);   // "elbow_pitch"
std::string get_label(const Experiment& e, const Effect& effect);        // "coulomb_friction@elbow_pitch"
std::string get_label(const Experiment& e, const Hypothesis& hypothesis);

// Which effects at which places, whatever their parameters and order.
using EffectSet = std::vector<std::pair<EffectId, Place>>;
EffectSet make_set(const Hypothesis& hypothesis);
// Whether an effect is in a hypothesis at a place, with whatever parameters.
bool contains(const Hypothesis& hypothesis, EffectId id, const Place& place);

// Of the drives' loops: last in a hypothesis.
bool is_timing_row(const EffectInfo& row);
bool is_timing(const Effect& effect);

struct Plant {
  TreeSpec tree;
  std::shared_ptr<const Model> model;
  std::vector<JointLaws> laws;          // by joint
  std::vector<double> rotor;            // [kg m^2] reflected inertia added by effects to links without elasticity
  std::vector<SteadyForce> forces;
  std::vector<SensorErrors> faults;     // by joint * 3 + quantity, on the first axis
  LoopTiming timing;
  bool effort_driven = false;
};

Plant make_plant(const Experiment& e, const Hypothesis& hypothesis);

// [s] by which a joint's recorded effort is behind its true time.
double get_effort_delay(const Plant& plant, int joint);

// The same with what hung on it and what pulled at it in one recording. Whatever else a plant has stays as it is: effects are
// of the robot, not of what somebody hangs on it.
Plant add_by_hand(Plant plant, const RecordingSpec& recording);
Plant make_plant(const Experiment& e, const Hypothesis& hypothesis, const RecordingSpec& recording);

}  // namespace hrp::diagnosis
