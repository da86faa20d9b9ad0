// SPDX-License-Identifier: BSD-3-Clause
// Finds the one recording in which a fixed-base robot carries something that it does not carry in the others.
//
// One model for all recordings spreads such a load over all of them: it biases friction and rotors, and is named nowhere.
// Friction, rotor, constant, gain and a load that is always there are the same in all recordings of a machine; a load in one
// of them has the torque of a mass along that recording's motion alone.
#pragma once

#include <optional>

#include "diagnosis/measurement/torque.h"

namespace hrp::diagnosis {

struct OddLoad {
  std::string file;                // of the recording
  int link = 0;                    // that carries the load
  double mass = 0.0, std = 0.0;    // [kg] more than in the other recordings
  Vector3d com_L, com_std;         // [m]
  double share = 0.0;              // of the torque that one model for all recordings leaves, 0 to 1
  bool leave_out = false;          // other recordings have the same role: the search does without this one
};

// Empty with one file only, without recorded efforts, or if no load in one file alone explains most of what is left.
std::optional<OddLoad> find_odd_load(const TorqueData& data);

// The experiment without the recordings of that file.
Experiment leave_out(Experiment experiment, const OddLoad& load);

}  // namespace hrp::diagnosis
