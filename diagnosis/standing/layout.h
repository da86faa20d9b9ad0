// SPDX-License-Identifier: BSD-3-Clause
// The order of a standing robot's channels in a sample's row.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

struct Channel {
  std::string kind;                       // as channels.h has them
  std::string signal;                     // the recorded signal nearest to it, as in the report
  std::string joint, foot, sensor, link;  // where it points, empty where it does not
};
std::vector<Channel> list_channels(const StandProblem& problem);

// First channels of places that are known but for a constant (stand, gap), and how many.
size_t find_places(const StandProblem& problem);
size_t count_places(const StandProblem& problem);

// First channel of the drives, and how many each joint has.
size_t find_drives(const StandProblem& problem);
size_t count_drive_channels(const StandProblem& problem, size_t joint);
size_t find_drive(const StandProblem& p, size_t joint);  // first channel of a joint

}  // namespace hrp::diagnosis::standing
