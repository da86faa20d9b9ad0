// SPDX-License-Identifier: BSD-3-Clause
// What of a foot touches the ground, from the collision shapes of its link.
#pragma once

#include "common/robot/robot_description.h"
#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// Fills kind, radius, bush, sole and size of a foot whose link is known: one sphere is a ball; else the lowest points
// of all shapes (corners, spheres set under the corners of a sole, vertices of a mesh) span a flat sole.
void read_sole(const RobotDescription& robot, StandFoot* foot);

}  // namespace hrp::diagnosis::standing
