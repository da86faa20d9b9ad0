// SPDX-License-Identifier: BSD-3-Clause
// Limits of a proposed motion, by joint.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

constexpr double kUsedShare = 0.9;                 // share of a joint's largest speed and effort that commands use
constexpr double kSpeedMargin = 1.0 / kUsedShare;  // factor on the commanded speed that the joint itself may reach
constexpr double kPeriod = 0.004;                  // [s] sampling time of commands
// A motion should be stopped if a joint differs from its command by this factor times the expected difference, plus
// this [rad or m]. The robot then has an effect that no explanation contains.
constexpr double kStopFactor = 1.5, kStopMore = 0.05;

struct JointLimits {
  double lower = 0.0, upper = 0.0;                // [rad or m] for commands
  double widest_lower = 0.0, widest_upper = 0.0;  // [rad or m] for commands, whatever reach is stated
  double hard_lower = 0.0, hard_upper = 0.0;      // [rad or m] for the joint itself, under every explanation
  double speed = 0.0;                             // [rad/s or m/s] for commands; the joint itself may be a ninth faster
  double effort = 0.0;                            // [N m or N] of the drive
  double start = 0.0;                             // [rad or m] position at which motions start and end
  MimicSpec mimic;                                // such a joint has no motion of its own
};

struct Limits {
  std::vector<JointLimits> joints;
  double ground = 0.0;                                    // [m] least height of links above the ground, if there is one
  double load = std::numeric_limits<double>::infinity();  // [kg] largest load by hand
  std::vector<std::string> remarks;                       // what was unknown, and what is used instead
};

// Limits from the robot's description and from `stated`: "speed=0.5", "effort=20", "reach=0.6" (all joints),
// "elbow.speed=0.3", "elbow.lower=-1", "load=1". Or the name of a YAML file with the same words: speed: 0.5, joints:
// {elbow: {speed: 0.3}}. Stated limits only tighten the description's; a stated reach stands for
// the usual half turn. Throws InputError if they cannot be read.
Limits make_limits(const Experiment& experiment, const std::vector<std::string>& stated);

// [rad or m] range of a joint's recorded commands, or of its positions without commands. Below kStill the joint has
// shown nothing.
double calc_travel(const Experiment& experiment, int joint);
constexpr double kStill = 0.05;

}  // namespace hrp::diagnosis
