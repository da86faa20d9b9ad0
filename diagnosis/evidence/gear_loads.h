// SPDX-License-Identifier: BSD-3-Clause
// What loads a gear, asked again once the rest of the model is known. Before that, the load of a gear is that of the
// model's bodies, or the effort that bodies, friction, rotor and a spring predict. A wrong centre of mass or a load in the
// hand is in neither, and friction of the load then fits badly. The recorded effort contains all of them.
#pragma once

#include "diagnosis/evidence/torque_model.h"

namespace hrp::diagnosis {

// Takes the recorded effort as the load of each joint where friction of that load beside the model is worth its cost, and
// builds the design again. The effort's own errors hardly matter: in the product of load and direction they have no mean.
// Returns false, without any change, if there is no such joint.
bool reload_gears(const TorqueModel& model, TorqueDesign* design);

// [nats] by which the fit `a` is better. Independent samples are those of both, as a better fit leaves less correlated
// residuals.
double calc_gain(const TorqueDesign& design_a, const TorqueFit& a, const TorqueDesign& design_b, const TorqueFit& b);

}  // namespace hrp::diagnosis
