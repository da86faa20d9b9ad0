// SPDX-License-Identifier: BSD-3-Clause
// Families of motions for a robot on a fixed base. Every motion starts and ends at rest in the robot's pose.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/limits.h"

namespace hrp::diagnosis {

// After kCount: motions of robots on their feet (stance_motions.h).
enum class Family {
  kMultisine,
  kTwoSpeeds,
  kSteps,
  kChirp,
  kPostures,
  kCreep,
  kRipple,
  kCount,
  kSway = kCount,
  kLean,
  kSquat,
  kStir,
  kSwing,
  kTurn,
  kWalk,
  kEnd
};
const char* get_family_word(Family family);      // "two_speeds", for file names
const char* get_family_sentence(Family family);  // what people see the robot do

// Commands of all joints with a fixed sampling time.
struct Commands {
  std::vector<double> time;                   // [s] from 0
  std::vector<std::vector<double>> position;  // [rad or m] by joint, by sample
  std::vector<std::vector<double>> velocity;  // [rad/s or m/s]
};

// [Hz] of the quickest of several sines. Where efforts limit a motion, slow sines reach further: they show friction and
// weight better, quick ones inertia.
constexpr double kQuickSines = 3.0, kSlowSines = 1.2;

struct MotionPlan {
  Family family = Family::kMultisine;
  std::vector<char> moves;  // by joint; the others hold their position, or follow another joint (`mimic`)
  unsigned seed = 1;
  double size = 1.0;           // share of the range that limits leave
  std::vector<double> shares;  // by joint, factor on `size`; empty: 1
  double seconds = 10.0;
  double period = 0.004;          // [s] between samples
  double quickest = kQuickSines;  // [Hz] of several sines
  std::vector<LoadSpec> loads;    // that hang on the robot
};

// [-] share of the range that limits leave to a joint.
double get_size(const MotionPlan& plan, size_t joint);

// Central differences of commands at equal steps [s]; both ends are at rest.
std::vector<double> calc_rates(const std::vector<double>& q, double period);

// Moves joints with `mimic` as the mechanism does, whatever they had.
void follow_leaders(const Limits& limits, std::vector<std::vector<double>>* columns, bool rates);

// The commands of a plan, within the positions and speeds of `limits`.
Commands make_motion(const MotionPlan& plan, const Limits& limits);

}  // namespace hrp::diagnosis
