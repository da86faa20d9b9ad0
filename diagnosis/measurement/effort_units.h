// SPDX-License-Identifier: BSD-3-Clause
// Logged efforts that are no torques: drives often log their current [A], or a share of their limit.
//
// Along the recorded motion effort = tau / k + friction + rotor, with tau the nominal inverse dynamics and k [N m per
// logged unit]. Noise and what the model lacks draw a regression of effort on tau towards zero, and one of tau on effort
// as well: the two slopes bracket 1 / k (Frisch's bounds). Links' masses are not too large by more than a factor of e;
// where every joint that tells asks for so much less effort, the unit is the cause. A load may ask for ten times the
// effort, but not for the same factor at two joints.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

struct EffortUnit {
  int joint = 0;
  double scale = 1.0;              // torque [N m, or N] of one logged unit
  double low = 1.0, high = 1.0;    // bracket of the scale
  bool by_others = false;          // this joint cannot tell; its neighbours' value is taken
  bool of_gains = false;           // no effort was logged: the servo's stated gains are in another unit
};

// One entry for each joint whose efforts, or without them whose stated gains, are in another unit; empty where they are
// torques or where the motion does not tell. Logged efforts of a servo are compared with its law elsewhere. Throws InputError where the sign of an effort is turned.
std::vector<EffortUnit> find_effort_units(const TorqueData& data);

// The same experiment with efforts in N m and gains in N m/rad.
Experiment convert_efforts(Experiment experiment, const std::vector<EffortUnit>& units);

}  // namespace hrp::diagnosis
