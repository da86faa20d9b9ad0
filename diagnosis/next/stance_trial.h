// SPDX-License-Identifier: BSD-3-Clause
// Simulates a motion of a standing robot with feet, ground and drives, and checks its safety.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/motions.h"

namespace hrp::diagnosis {

// [m] Least distance of the zero-moment point from the soles' edge. A robot that stands nearer than that at rest has
// stood so in its recordings: there a motion may take a fifth of that distance.
constexpr double kZmpMargin = 0.015, kRestShare = 0.8;

constexpr double kStretch = 0.05;  // [s] over which readings are averaged, because light soles chatter in simulation

struct StanceRun {
  std::string fault;      // empty: safe. Example: "the zero-moment point comes within 0.004 m of the soles' edge"
  double margin = 1e300;  // [m] smallest distance of the zero-moment point from that edge
  std::vector<double> readings;  // [stretch][signal]: position, effort of joints; force, torque of sensors
  std::vector<double> leave;     // [rad or m] by joint: largest difference from its command
};

// Runs `scenario`: stands for two seconds, then plays the motion. `walks`: feet may leave the ground; the zero-moment
// point stays inside the soles that carry the robot.
StanceRun run_stance(const Experiment& experiment, const Scenario& scenario, const Commands& commands,
                     const Limits& limits, bool walks = false);

}  // namespace hrp::diagnosis
