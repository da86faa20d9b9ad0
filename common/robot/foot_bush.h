// SPDX-License-Identifier: BSD-3-Clause
// Rubber bush in a foot: three passive joints in series (slide z, roll, pitch; Nakaoka 2007, [M14]) between what stays
// above the force sensor's bush and the sole. The simulator integrates their springs and dampers implicitly.
#pragma once

#include <string>

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp {

// Cuts the foot's link in two. The link itself keeps spec.upper_mass_ratio of mass and inertia, its joint and its
// frames, so that a force sensor there is above the bush; the rest and all shapes go to the new link "<foot>_sole".
// New joints, appended in this order: "<foot>_bush_z", "<foot>_bush_roll", "<foot>_bush_pitch", unactuated, about the
// foot link's axes through the bush's centre. Effort = -K q - C qd - O (O: offset of roll and pitch).
// Throws InputError: unknown foot, foot with joints below it, stiffness that is not positive.
void insert_foot_bush(const std::string& foot, const FootBushSpec& spec, RobotDescription* robot);

// All bushes of the scenario.
void insert_foot_bushes(const Scenario& scenario, RobotDescription* robot);

// Is this the name of such a joint? No encoder reads it, so a robot's own recordings have no such column.
bool is_bush_joint(const std::string& joint);

}  // namespace hrp
