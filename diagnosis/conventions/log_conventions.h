// SPDX-License-Identifier: BSD-3-Clause
// Logs of real machines that count otherwise than the model: angles of motors before their gears
// (measurement/gear_ratios.h), efforts that are currents (conventions/effort_units.h), joints whose zero is elsewhere
// (measurement/joint_zeros.h). They are found first, taken out of the recordings, and said; so is friction that the
// model states and that is not there (stated_friction.h). Sensors of a body have units, too
// (floating/conventions/body_units.h), axes and clocks (floating/conventions/sensor_frames.h), sides
// (floating/conventions/exchanged_sides.h), and are above the foot or below it (floating/log/whole_readings.h). All
// else is then judged in the model's own units.
#pragma once

#include "diagnosis/conventions/absent_torque.h"
#include "diagnosis/conventions/absolute_angles.h"
#include "diagnosis/conventions/effort_units.h"
#include "diagnosis/conventions/gear_report.h"
#include "diagnosis/conventions/late_commands.h"
#include "diagnosis/conventions/remarks.h"
#include "diagnosis/conventions/stated_friction.h"
#include "diagnosis/conventions/turned_efforts.h"
#include "diagnosis/floating/conventions/body_units.h"
#include "diagnosis/floating/conventions/exchanged_sides.h"
#include "diagnosis/floating/conventions/gone_gravity.h"
#include "diagnosis/floating/conventions/pose_frames.h"
#include "diagnosis/floating/conventions/sensor_frames.h"
#include "diagnosis/floating/conventions/turned_efforts.h"
#include "diagnosis/floating/conventions/turned_legs.h"
#include "diagnosis/floating/log/whole_readings.h"
#include "diagnosis/measurement/joint_zeros.h"
#include "diagnosis/report/first.h"

namespace hrp::diagnosis {

struct LogConventions {
  // Efforts with the opposite sign; those by the servo's law are turned where they are read
  std::vector<TurnedEffort> signs;
  AbsentTorque absent;
  AbsoluteAngles angles;
  Ratios ratios;
  LateCommands commands;
  std::vector<EffortUnit> units;
  // Joints whose recorded effort may be in any unit: neither the motion nor other joints tell it
  std::vector<EffortUnit> untold;
  std::vector<JointZero> zeros;
  std::vector<RefutedFriction> friction;
  std::vector<floating::GoneGravity> weightless;
  std::vector<floating::BodyUnit> bodies;
  std::vector<floating::SensorFrame> frames;
  std::vector<floating::WholeReading> whole;
  floating::ExchangedSides sides;
  floating::TurnedJoints turned,
      efforts;  // encoders of legs, told by standing feet; efforts of legs, told by the body's balance
  floating::PoseFrame pose;
  bool any() const {
    return counts_otherwise() || !ratios.doubted.empty() || !friction.empty() || !whole.empty() || sides.any() ||
           !turned.joints.empty();
  }
  bool counts_otherwise() const {
    return !signs.empty() || absent.part != Absent::kNothing || angles.any() || !ratios.found.empty() ||
           commands.any() || !units.empty() || !zeros.empty() || !weightless.empty() || !bodies.empty() ||
           !frames.empty() || !efforts.joints.empty() || pose.any();
  }
};

// Efforts, zeros and friction for robots on a fixed base, sensors of the body for others. Throws InputError, with file
// and column, where the sense of a joint is turned, or two joints are exchanged.
LogConventions find_conventions(const Experiment& experiment, int jobs);

// What was found, in a line each, and what recordings are too short for.
ConventionRemarks make_remarks(const Experiment& as_logged, const LogConventions& conventions);

// The recordings as the model counts, and the model without what they refute.
Experiment convert_recordings(const Experiment& experiment, const LogConventions& conventions);

// Adds a finding for each, its entry in the model, and warnings. What was found of the same kind in converted
// recordings is taken together with it.
void add_conventions(const Experiment& as_logged, const LogConventions& conventions, Reports* reports);

}  // namespace hrp::diagnosis
