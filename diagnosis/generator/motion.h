// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "diagnosis/generator/prng.h"
#include "diagnosis/generator/robot_plan.h"

namespace hrp::cases {

// Commands of every joint, sampled at `time`; between samples a cubic Hermite of position and velocity, before and
// after them the first and last position at rest.
struct Commands {
  std::vector<double> time;
  std::vector<std::vector<double>> position, velocity;  // [joint][sample]

  void find(int joint, double t, double& position_out, double& velocity_out) const;
  // The same motion at other times, such as the stamps of a recorder.
  Commands sample(const std::vector<double>& at) const;
};

// Draws a motion for the robot and samples it at the given times. Kinds: for arms `multisine`, `trapezoid`, `step`,
// `slow`; for bipeds `sway`, `squat`, `spread`, `release`, `limbs`.
Commands make_commands(const RobotPlan& robot, const std::string& kind, const std::vector<double>& time, Prng& random);

std::vector<std::string> draw_motion_kinds(const RobotPlan& robot, Prng& random);  // five, the last two to validate

}  // namespace hrp::cases
