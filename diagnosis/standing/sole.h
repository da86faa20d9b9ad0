// SPDX-License-Identifier: BSD-3-Clause
// Determines the contact surface of a foot from the collision shapes of its link.
#pragma once

#include "common/robot/robot_description.h"
#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// [rad/(N m)] A sole and its ground that give less are rigid: stiffer than 5e4 N m/rad.
constexpr double kRigidTilt = 2e-5;

// [m] Largest height difference of a sole's points: treads, rounded edges.
constexpr double kLevel = 0.005;

// Fills kind, radius, bush, sole and size of a foot whose link is known. A single sphere is a ball. Otherwise the
// lowest points of all shapes (corners, spheres under the corners, mesh vertices) span a flat sole.
void read_sole(const RobotDescription& robot, StandFoot* foot);

}  // namespace hrp::diagnosis::standing
