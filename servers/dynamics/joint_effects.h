// SPDX-License-Identifier: BSD-3-Clause
// The laws of all joints of a scenario: nominal ones, and what scenario.joint_laws adds from the table of effects.
#pragma once

#include <string>
#include <vector>

#include "common/effects/joint_law.h"
#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// Switches an effect on. Throws InputError naming joint, effect, parameter, value and bounds of what is wrong.
void apply_stated_joint_effect(const std::string& joint, const StatedEffect& stated, JointLaws* laws);

// Laws of every joint of the tree as the scenario has them. Moves rotor inertias of elastic joints from the tree to
// the motor side and puts those of the scenario in. Throws InputError.
std::vector<JointLaws> make_joint_laws(const Scenario& scenario, TreeSpec* tree);

}  // namespace hrp
