// SPDX-License-Identifier: BSD-3-Clause
// Units of efforts of a robot that carries something, and has springs. Joint by joint, the torque of a load or of a
// spring looks like a larger unit. All joints carry the same load, but each has its own unit: together they tell both.
//
//   y_j = g_j (tau_j + L_j p) + N_j x_j      y_j: logged effort, g_j: logged units per N m, tau_j: nominal torque,
//                                            L_j p: torque of the load's mass and moment p (the same for all joints),
//                                            N_j x_j: friction, rotor, constant and, where it shows, a spring, in
//                                            logged units
//
// Least squares in y with p shared (a profile likelihood): what no law describes is in y.
#pragma once

#include <limits>
#include <vector>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// The unit of one joint beside a load and a spring.
struct LoadedUnit {
  int joint = 0;
  double scale = 1.0, std = 0.0;  // torque [N m or N] per logged unit; it contains the load's uncertainty
  double share = 0.0;             // of what friction and rotor leave of y that the torque explains, 0 to 1
  double moved = 0.0;             // [N m or N] standard deviation of the torque that friction, rotor and spring leave
};

struct LoadedUnits {
  std::vector<LoadedUnit> joints;
  int link = -1;      // that carries the load; -1: no load explains more than units do
  double mass = 0.0;  // [kg]
  double blur = std::numeric_limits<double>::infinity();  // relative deviation of its mass or moment, the larger one
  double of_torque = 0.0;  // the same of the torque of the joint that bears the load most: a small load blurs no unit
  double by_load = 0.0;    // [nats] by which the load explains more than units alone
};

// `joints`: those whose efforts are recorded and are no torques. Empty if neither a load nor springs explain more than
// units alone do.
LoadedUnits find_loaded_units(const TorqueData& data, const std::vector<int>& joints);

}  // namespace hrp::diagnosis
