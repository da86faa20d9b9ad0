// SPDX-License-Identifier: BSD-3-Clause
// Families of motions that a robot on a fixed base can play. Every motion begins and ends at rest where the robot stands.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/limits.h"

namespace hrp::diagnosis {

// Behind kCount: of robots on their feet (stance_motions.h).
enum class Family { kMultisine, kTwoSpeeds, kSteps, kChirp, kPostures, kCreep, kRipple, kCount, kSway = kCount, kLean, kSquat, kStir, kEnd };
const char* get_family_word(Family family);      // "two_speeds": of file names
const char* get_family_sentence(Family family);  // what people see the robot do

// Commands of all joints at regular times.
struct Commands {
  std::vector<double> time;                     // [s] from 0
  std::vector<std::vector<double>> position;    // [rad or m] by joint, by sample
  std::vector<std::vector<double>> velocity;    // [rad/s or m/s]
};

struct MotionPlan {
  Family family = Family::kMultisine;
  std::vector<char> moves;   // by joint; the others hold
  unsigned seed = 1;
  double size = 1.0;         // of the range that limits leave
  double seconds = 10.0;
  double period = 0.004;     // [s] between samples
  std::vector<LoadSpec> loads;  // that somebody hangs on the robot before it
};

// Within positions and speeds of `limits`, as commands.
Commands make_motion(const MotionPlan& plan, const Limits& limits);

}  // namespace hrp::diagnosis
