// SPDX-License-Identifier: BSD-3-Clause
// Joints whose recorded positions are not in the model's radians: angles of the motor before its gear, or of a driver
// that divides by the ratio of another gear.
//
// Effort = tau(q / N, v / N, a / N) + friction + rotor, with the ratio N of one joint. Weight follows the sine of the
// true angle and inertia its second derivative, so no mass, place or friction of the model gives the torque of another
// ratio. The logged effort is the link's, or the motor's: 1 / N of it, since a gear keeps the power. The search uses
// the full inverse dynamics, joint by joint.
#pragma once

#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

struct GearRatio {
  int joint = 0;
  double ratio = 1.0, std = 0.0;  // recorded angle = ratio x true angle
  bool of_motor = false;          // the effort is that of the motor: true effort = ratio x recorded effort
  double left = 1.0;    // squares of the missing torque that remain, relative to those of the angles as logged
  bool agreed = false;  // every recording alone asks for a ratio on the same side of one, and they agree
};

// Ratios of single joints that explain the efforts of all joints better than angles as logged, the best first.
std::vector<GearRatio> list_gear_ratios(const TorqueData& data);

// The experiment with positions, rates and commands of the joint. A command or a velocity that is already in the
// model's unit stays.
Experiment convert_ratio(Experiment experiment, const GearRatio& ratio);

}  // namespace hrp::diagnosis
