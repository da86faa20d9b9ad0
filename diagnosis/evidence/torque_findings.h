// SPDX-License-Identifier: BSD-3-Clause
// What the missing torque of a robot on a fixed base says: findings, what remains, and the model for a simulation.
#pragma once

#include "diagnosis/findings/finding.h"
#include "diagnosis/measurement/torque.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

struct TorqueVerdict {
  bool judged = false;    // else `evidence.missing` says what was not recorded
  Evidence evidence;      // without `fit`, `mismatch` and `verdict`
  Hypothesis model;       // all terms that help to predict, for `updated/`
  int joints = 0;         // that are judged
  int exact = 0;          // of them, those whose missing torque is small and follows nothing: noise
  std::vector<size_t> frozen;  // recordings whose log freezes: no simulation follows them
  int drive_terms = 0;    // friction and rotors that are supported
  int with_drives = 0;    // of them, those with friction or a rotor that is supported
  int any_drives = 0;     // the same, ambiguous ones too
  std::vector<SignalFit> torque;  // by joint: root mean squares of the missing torque, held-out recordings [N m]
};

TorqueVerdict judge_torque(const Experiment& experiment, int jobs);
TorqueVerdict judge_torque(TorqueData&& data, int jobs);

// Share of the joints in which friction or a rotor is found, from which sets of a few effects cannot explain the
// robot: each joint has several of its own.
constexpr double kEveryDrive = 0.6;
bool has_real_drives(const TorqueVerdict& torque);

}  // namespace hrp::diagnosis
