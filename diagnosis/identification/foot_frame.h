// SPDX-License-Identifier: BSD-3-Clause
// A foot as the bush divides it: U above (the foot link, origin in the ankle), S the sole below, R_US = Rx(roll)
// Ry(pitch).
#pragma once

#include <vector>

#include "common/robot/robot_description.h"
#include "common/robot/scenario.h"

namespace hrp::identification {

struct FootFrame {
  int link = 0;
  Vector3d p_UC = Vector3d::Zero();     // [m] centre of the bush
  double mass = 0.0, upper_mass = 0.0;  // [kg] of the foot, and above the bush
  Vector3d p_Ucm = Vector3d::Zero();    // [m]
  Eigen::AlignedBox2d sole;             // [m] outline about C, U's x and y; empty when the robot has no shape there
};

// The robot as its URDF describes it: no bushes, no laws of their joints or of others.
Scenario without_bush(Scenario scenario);

// The feet of a robot without bushes; of the scenario's bushes only the place (centre, share of mass) is used. Throws
// InputError.
std::vector<FootFrame> make_feet(const Scenario& scenario, const RobotDescription& robot);

// Angles of the bush [rad].
struct BushAngles {
  double roll = 0.0, pitch = 0.0;
};
// From the vertical in U while S is level: it is (sin p, -sin r cos p, cos r cos p).
BushAngles calc_angles(const Vector3d& n_U);
Matrix3d make_R_SU(const BushAngles& angles);

}  // namespace hrp::identification
