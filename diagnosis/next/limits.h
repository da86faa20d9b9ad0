// SPDX-License-Identifier: BSD-3-Clause
// What a proposed motion must keep to, by joint.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

constexpr double kUsedShare = 0.9;                // of the speed and effort that a joint may have: what commands use
constexpr double kSpeedMargin = 1.0 / kUsedShare;  // of the speed of commands, by which the joint itself may be faster
constexpr double kPeriod = 0.004;                 // [s] between samples of commands
// Where to stop a motion: beyond so many times what a joint is expected to leave its command by, and so much more [rad or m]. A
// robot that goes further has something that nobody thought of.
constexpr double kStopFactor = 1.5, kStopMore = 0.05;

struct JointLimits {
  double lower = 0.0, upper = 0.0;            // [rad or m] of commands
  double hard_lower = 0.0, hard_upper = 0.0;  // [rad or m] of the joint itself, under every explanation
  double speed = 0.0;               // [rad/s or m/s] of commands; the joint itself may be a ninth faster
  double effort = 0.0;              // [N m or N] of the drive
  double start = 0.0;               // [rad or m] where motions begin and end
};

struct Limits {
  std::vector<JointLimits> joints;
  double ground = 0.0;               // [m] least height of links above the ground, where there is one
  double load = std::numeric_limits<double>::infinity();  // [kg] that somebody may hang on the robot
  std::vector<std::string> remarks;  // what was not known and what was taken instead
};

// `stated`: "speed=0.5", "effort=20", "reach=0.6" (of all joints), "elbow.speed=0.3", "elbow.lower=-1", "load=1"; or the name of a
// YAML file with the same words: speed: 0.5, joints: {elbow: {speed: 0.3}}. They tighten what the robot's description
// allows and never widen it. Throws InputError for what cannot be read.
Limits make_limits(const Experiment& experiment, const std::vector<std::string>& stated);

}  // namespace hrp::diagnosis
