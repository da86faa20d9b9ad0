// SPDX-License-Identifier: BSD-3-Clause
// What loads a gear, asked again once the rest of the model is known. Before that, the load of a gear is that of the
// model's bodies, or the effort that bodies, friction, rotor and a spring predict. A wrong centre of mass or a load in
// the hand is in neither, and friction of the load then fits badly. The recorded effort contains all of them.
#pragma once

#include "diagnosis/evidence/torque/model.h"

namespace hrp::diagnosis {

// Takes the recorded effort as the load of each joint where friction of that load beside the model is worth its cost,
// and builds the design again. Returns false, without any change, if there is no such joint.
bool reload_gears(const TorqueModel& model, TorqueDesign* design);

struct FittedModel {
  const TorqueDesign& design;
  const TorqueModel& model;
  const TorqueFit& fit;
};

// [nats] by which `a` is better. Independent samples are those of both, as a better fit leaves less correlated
// residuals.
double calc_gain(const FittedModel& a, const FittedModel& b);

}  // namespace hrp::diagnosis
