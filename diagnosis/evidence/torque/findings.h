// SPDX-License-Identifier: BSD-3-Clause
// Judges the missing torque of a fixed-base robot: findings, what remains, and the model for a simulation.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/measurement/torque/torque.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Result of the missing torque of all joints.
struct TorqueVerdict {
  bool judged = false;            // if false, `evidence.missing` says what was not recorded
  Evidence evidence;              // without `fit`, `mismatch` and `verdict`
  Hypothesis model;               // all terms that improve the prediction, for `updated/`
  int joints = 0;                 // that are judged
  int exact = 0;                  // judged joints whose missing torque is small and unpredictable: noise
  std::vector<size_t> frozen;     // recordings whose log freezes; no simulation can follow them
  int drive_terms = 0;            // number of supported friction and rotor terms
  int with_drives = 0;            // number of joints with such terms
  int any_drives = 0;             // the same including ambiguous terms
  std::vector<SignalFit> torque;  // by joint: root mean squares of the missing torque, held-out recordings [N m]
};

// Judges the missing torque of an experiment, or of given data. Nothing is judged without recordings or judged joints.
TorqueVerdict judge_torque(const Experiment& experiment, int jobs);
TorqueVerdict judge_torque(TorqueData&& data, int jobs);

// Least share of joints with friction or a rotor at which the robot counts as having real drives. Sets of a few effects
// cannot explain such a robot, as each joint has several effects.
constexpr double kEveryDrive = 0.6;

// True if friction or rotors are found in most joints, so that sets of a few effects cannot explain the robot.
bool has_real_drives(const TorqueVerdict& torque);
// True if at most 40 % of the joints are exact. A faulty sensor that all joints depend on may hide that each has
// friction.
bool may_have_real_drives(const TorqueVerdict& torque);

}  // namespace hrp::diagnosis
