// SPDX-License-Identifier: BSD-3-Clause
// Finds what a fixed-base robot carries for a part of the recordings only: one of them, or since it took something up.
//
// One model for all recordings spreads such a load over all of them: it biases friction and rotors, and is named
// nowhere. Friction, rotor, constant, gain and a load that is always there are the same at all times; a load for a part
// of them has the torque of a mass along the motion of that part alone.
#pragma once

#include <optional>

#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// A stretch of one file.
struct LoadedPart {
  std::string file;
  bool whole = true;              // all of it
  double begin = 0.0, end = 0.0;  // [s] the load was there from no later than, and until no earlier than
};

struct OddLoad {
  std::vector<LoadedPart> parts;  // one of each file
  int link = 0;                   // that carries the load
  double mass = 0.0, std = 0.0;   // [kg] more than at other times
  Vector3d com_L, com_std;        // [m]
  double share = 0.0;             // of the torque that one model for all recordings leaves, 0 to 1
  bool leave_out = false;         // enough of each role is left: the search does without these parts
};

// Empty without recorded efforts, or if no load for a part of the time explains most of what is left.
std::optional<OddLoad> find_odd_load(const TorqueData& data);

// The experiment without these parts of the recordings.
Experiment leave_out(const Experiment& experiment, const OddLoad& load);

}  // namespace hrp::diagnosis
