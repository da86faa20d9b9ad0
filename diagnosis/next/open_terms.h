// SPDX-License-Identifier: BSD-3-Clause
// What a report of many effects leaves open, as terms of the missing torque (measurement/torque/terms.h). Each question
// is about one finding: it may be another effect, or nothing. All other terms stay, with free values.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {

// One side of a question: a model of the missing torque, fitted to the recordings, and the same as effects that can be
// simulated.
struct TorqueSide {
  TorqueModel model;
  TorqueFit fit;
  Slots slots;
  Hypothesis hypothesis;
};

struct OpenQuestion {
  std::string label;  // "viscous_friction@elbow instead of coulomb_friction@elbow"
  TorqueSide truth, rival;
  bool added = false;  // the truth has an effect that the report's model lacks
  // The side that is not the report's model.
  const TorqueSide& shown() const { return added ? truth : rival; }
};

// A value of the report with the parameter of the best model that it follows from.
struct OpenValue {
  EffectId effect = kNoEffect;
  Place place;
  std::string label, parameter, unit;
  double value = 0.0, half_width = 0.0;  // of the report's 95 % interval
  long slot = 0;                         // in `best`
  int dry_joint = -1;                    // joint of a level of dry friction, which varies over a turn; -1: none
};

struct OpenTerms {
  TorqueDesign design;
  TorqueSide best;  // the report's model
  std::vector<OpenQuestion> questions;
  std::vector<OpenValue> values;
  std::vector<std::string> untold;  // alternatives that are no function of the motion, or the same in every motion
  bool any() const { return !design.joints.empty(); }
};

OpenTerms find_open_terms(const Experiment& experiment, const Json& report);

// Sentences of the report's own about motions that would tell, once each: "elbow: viscous_friction or coulomb_friction:
// ...". For robots to which no motion can be sent.
std::vector<std::string> list_motion_words(const Json& report);

}  // namespace hrp::diagnosis
