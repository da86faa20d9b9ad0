// SPDX-License-Identifier: BSD-3-Clause
// Order of a standing robot's channels within one sample.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// An equation, as in channels.h.
enum class ChannelKind { kTilt, kStand, kGap, kBalance, kBase, kEffort, kServo, kVelocity, kGyro, kGravity };
std::string get_text(ChannelKind kind);  // "tilt"

// One equation: its kind, and the signal and place that the report names.
struct Channel {
  ChannelKind kind;
  std::string signal;                     // recorded signal that is closest to it, as in the report
  std::string joint, foot, sensor, link;  // place of the equation; empty if not applicable
};
std::vector<Channel> list_channels(const StandProblem& problem);

// First channel of positions that are known except for a constant (stand, gap), and their number.
size_t find_places(const StandProblem& problem);
size_t count_places(const StandProblem& problem);

// First channel of the drives, and the number of channels of each joint.
size_t find_drives(const StandProblem& problem);
size_t count_drive_channels(const StandProblem& problem, size_t joint);
size_t find_drive(const StandProblem& p, size_t joint);  // first channel of a joint

}  // namespace hrp::diagnosis::standing
