// SPDX-License-Identifier: BSD-3-Clause
// The simulated robot: the experiment's nominal model with a list of effects and their parameters.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/effects/effect_target.h"
#include "common/effects/joint_law.h"
#include "common/multibody/model.h"
#include "diagnosis/data/recording.h"
#include "diagnosis/model/effect.h"
#include "servers/dynamics/link_effects.h"

namespace hrp::diagnosis {

// Parameters of an effect, in the order of its values. For single readings of a joint, a sensor fault has only its
// first axis.
const std::vector<EffectParameter>& list_infos(EffectId id);

std::string get_place_text(const Experiment& e, const Effect& effect);  // "elbow_pitch"
std::string get_label(const Experiment& e, const Effect& effect);       // "coulomb_friction@elbow_pitch"
std::string get_label(const Experiment& e, const Hypothesis& hypothesis);

// Effects and places of a hypothesis, without parameters and order.
using EffectSet = std::vector<std::pair<EffectId, Place>>;
EffectSet make_set(const Hypothesis& hypothesis);
// True if a hypothesis has the effect at the place, with any parameters.
bool contains(const Hypothesis& hypothesis, EffectId id, const Place& place);

// True for timing parameters of the drives; they are last in a hypothesis.
bool is_timing_row(const EffectInfo& row);
bool is_timing(const Effect& effect);

// All quantities of a simulated robot.
struct Plant {
  TreeSpec tree;
  std::shared_ptr<const Model> model;
  std::vector<JointLaws> laws;  // by joint
  std::vector<double> rotor;    // [kg m^2] reflected inertia that effects add to rigid joints
  std::vector<SteadyForce> forces;
  std::vector<SensorErrors> faults;  // by joint * 3 + quantity; first axis only
  LoopTiming timing;
  bool effort_driven = false;
};

// The nominal robot of an experiment with the effects of a hypothesis.
Plant make_plant(const Experiment& e, const Hypothesis& hypothesis);

// [s] Delay of a joint's recorded effort.
double get_effort_delay(const Plant& plant, int joint);

// The plant with the loads and forces by hand in one recording. Effects keep their values: they belong to the robot,
// not to what hangs on it.
Plant add_by_hand(Plant plant, const RecordingSpec& recording);
Plant make_plant(const Experiment& e, const Hypothesis& hypothesis, const RecordingSpec& recording);

}  // namespace hrp::diagnosis
