// SPDX-License-Identifier: BSD-3-Clause
// What an effect acts on: the pieces of a robot and its world at the effect's place. Null: the place has no such piece.
#pragma once

#include <vector>

#include "common/effects/joint_law.h"
#include "common/effects/world_spec.h"
#include "common/multibody/tree_spec.h"

namespace hrp {

// Loops of all drives against the recorded stamps.
struct LoopTiming {
  double command_shift = 0.0;  // [s] by which the stamps of commands run ahead of those of readings
  double rate_lag = 0.0;       // [s] by which the servo's velocity lags behind its position
  double clock_skew = 0.0;     // the clock of states runs (1 + skew) as fast as that of commands
};

struct EffectTarget {
  JointLaws* joint = nullptr;
  // Link: a payload goes to the first part only, other changes of mass to all (a foot above and below its bush).
  std::vector<LinkInertia*> link;
  Transform X_LF;               // frame in which a payload's place is written, in the link
  Vector3d* force_W = nullptr;  // [N] at the link's centre of mass
  FootBushSpec* bush = nullptr;
  GroundSpec* ground = nullptr;
  ContactSpec* contact = nullptr;
  double* drag = nullptr;  // [1/s] share of speed that a body loses in flight
  SensorErrors* sensor = nullptr;
  Vector3d* gravity_W = nullptr;  // [m/s^2] as the robot's base sees it
  LoopTiming* timing = nullptr;   // of all drives and clocks
};

}  // namespace hrp
