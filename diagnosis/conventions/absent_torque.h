// SPDX-License-Identifier: BSD-3-Clause
// Finds logged efforts that are not the whole torque of the drives: a controller's torque beside its gravity
// compensation lacks the weight of the model, and an estimate of the external torque lacks all that the model's bodies
// take.
//
//   y_j = tau_j - absent_j + L_j p + N_j x_j     absent_j: the model's weight, or all of tau_j; L_j p: torque of a load
//   of any
//                                                link, the same for all joints; N_j x_j: friction, rotor, constant
//
// A log in another unit, y_j = g_j tau_j + ..., holds little of the model's torque, too. There, a share of absent_j at
// each joint explains most of what is left. Where the torque is absent, it explains nothing.
#pragma once

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

enum class Absent { kNothing, kWeight, kBodies };

struct AbsentTorque {
  Absent part = Absent::kNothing;
  double left = 1.0;  // squares of the missing torque that remain, over those as logged
};

// kNothing unless clear: without weight, on a floating base, with efforts by a servo's law, and if a share of the
// model's torque, or another unit, explains as much.
AbsentTorque find_absent_torque(const TorqueData& data);

// The experiment with efforts to which the model's torque was returned.
Experiment return_torque(Experiment experiment, Absent part);

}  // namespace hrp::diagnosis
