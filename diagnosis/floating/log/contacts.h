// SPDX-License-Identifier: BSD-3-Clause
// Which feet carry the robot, and the phases of walking: from forces, else from kinematics.
#pragma once

#include "diagnosis/floating/log/body_motion.h"

namespace hrp::diagnosis::floating {

constexpr double kRaisedFoot = 0.012;  // [m] a foot this far above the lowest one swings, where no force tells
constexpr double kHalfFoot = 0.1;      // [m] lever by which moments of a foot are compared with its forces
// [s] A swing lasts longer, and what a landing shakes dies out: as scripts/diagnosis/walk_figures.py has it.
constexpr double kLanding = 0.25;

// One foot's time on the ground or in the air.
struct Contact {
  size_t clip = 0, foot = 0, begin = 0, end = 0;  // samples
  bool loaded = false;
};

// Two levels of a force sensor's reading, in its own unit: in the air and in stance.
struct ForceLevels {
  double air = 0, stance = 0;
  double air_spread = 0;  // deviation of what it reads there
  bool swings = false;    // the reading does fall to the level of the air
  bool cut = false;       // most readings there are one and the same: the log keeps no smaller ones
};

struct Contacts {
  std::vector<std::vector<std::vector<char>>> loaded;  // by clip, by foot, by sample
  std::vector<ForceLevels> levels;                     // by sensor
  std::vector<Contact> spells;
  bool walks = false;        // some foot leaves the ground and comes back
  bool from_forces = false;  // of every foot; else some are told by kinematics
  // Feet loaded at a sample as bits; the phase of walking it is in.
  int find_phase(size_t clip, size_t k) const;
  const char* find_phase_name(int phase) const;
};

// The phase in which every foot is loaded.
inline int get_phase_of_all(const LeggedLog& log) { return (1 << log.feet.size()) - 1; }

// Reading of a sensor along its foot's z axis, positive where the ground presses, [N] or its own unit.
double calc_vertical_force(const LeggedLog& log, const Clip& clip, size_t sensor, size_t k);

// Moment [N m] about the centre C of a foot's sole, foot axes, of a force [N] and a moment in a sensor's own axes. Of
// their rates: its rate.
Vector3d move_to_sole(const ForceSensor& sensor, const Foot& foot, const Vector3d& force_S, const Vector3d& moment_S);

Contacts find_contacts(const LeggedLog& log);

}  // namespace hrp::diagnosis::floating
