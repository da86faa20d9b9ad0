// SPDX-License-Identifier: BSD-3-Clause
// Elastic gears by the missing torque of the whole robot. Inverse dynamics along the encoders has the links move as the
// drives. Behind a gear that gives they do not, and at its resonance the torque of every joint is then wrong: gains,
// rotors and masses would stand in for it.
#pragma once

#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/model/effect.h"

namespace hrp::diagnosis {

// Lets gears of the design give, one after the other, while the model of the missing torque gains beyond their cost. A
// gear that leaves more than half of the squares may have play instead: it is noted, and the links stay as they are.
void soften_gears(int jobs, TorqueDesign* design, Choice* choice);

// Adds `joint_elasticity` of a gear that gives to the findings; ambiguous, with play as the alternative, if it was only
// noted. The effort tells the twist: one that was not recorded, but calculated with the servo's law (`source`), mixes
// the command into the motion as a gear would, so that another law or a late one does as well. In the model it replaces
// the rotor of its joint by an elastic transmission with that rotor; a gear that was only noted does not: the
// simulation then tries both laws (loose_gears.h).
void add_soft_gear(const Experiment& experiment, const SoftGear& gear, EffortSource source,
                   std::vector<Finding>* findings, Hypothesis* model);

}  // namespace hrp::diagnosis
