// SPDX-License-Identifier: BSD-3-Clause
// A motion of a standing robot, simulated with feet, ground and drives, and looked at for what must not happen.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/motions.h"

namespace hrp::diagnosis {

constexpr double kZmpMargin = 0.015;  // [m] of the zero-moment point from the edge of what the soles cover

constexpr double kStretch = 0.05;     // [s] over which readings are averaged: light soles chatter, in simulation at least

struct StanceRun {
  std::string fault;              // empty: safe. "the zero-moment point comes within 0.004 m of the soles' edge"
  double margin = 1e300;          // [m] least distance of the zero-moment point from that edge
  std::vector<double> readings;   // [stretch][signal]: of all joints position and effort; of all force sensors force and torque
  std::vector<double> leave;      // [rad or m] by joint: how far it is from its command at most
};

// Of `scenario`, which stands for one second at the beginning of the motion and then plays it.
StanceRun run_stance(const Experiment& experiment, const Scenario& scenario, const Commands& commands, const Limits& limits);

}  // namespace hrp::diagnosis
