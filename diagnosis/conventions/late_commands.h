// SPDX-License-Identifier: BSD-3-Clause
// Finds servos that act on something else than the logged commands, where no effort was recorded: the servo's law is
// all that is known of the drive.
//
// A log may write commands late: the servo then acts on what is logged a moment later. Or the servo damps the error of
// the velocity, kd (r' - q'), and the commanded velocity was not logged. To first order in time, the second is the
// first with a delay of kd / kp. Both look like friction that drives the joint, which no drive has; a rotor stands in
// for a part of it. Commands that reach the drive late are no matter of the log (command_delay).
#pragma once

#include <string>

#include "diagnosis/data/recording.h"
#include "diagnosis/report/report.h"

namespace hrp::diagnosis {

struct LateCommands {
  double delay = 0.0, std = 0.0;  // [s] by which the log of commands is late; 0: it is not
  bool of_rate = false;           // instead, damping acts on the error of the velocity
  bool either = false;  // recordings hardly tell which of the two: they differ in the second order of the delay

  bool damps_late = false;  // servos damp with a late velocity: as it was logged, or
  double filter = 0.0;      // [s] behind a filter of this time constant that no log shows

  bool is_of_commands() const { return delay != 0.0 || of_rate; }
  bool any() const { return is_of_commands() || damps_late; }
};

LateCommands find_late_commands(const Experiment& experiment, int jobs);

// Commands and velocities as the servos had them: moved, without the last samples, or with their rates.
Experiment convert_commands(Experiment experiment, const LateCommands& late);

// In one sentence; empty if there is nothing to say.
std::string describe(const LateCommands& late);

// The finding of a log that is, or may be, late; else null.
Json make_late_finding(const Experiment& as_logged, const LateCommands& late);

}  // namespace hrp::diagnosis
