// SPDX-License-Identifier: BSD-3-Clause
// Finds where the link behind a loose transmission is in its gap. A torque holds it at one end. Without torque it is
// free, and the standing feet tell where it is.
#pragma once

#include <vector>

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

struct StandBase;

using PlayOffsets = std::vector<std::vector<double>>;  // [rad] by joint, by sample; empty where nothing is loose

// By joint: torque [N m] that exceeds the noise.
std::vector<double> find_slack(const StandProblem& problem, const std::vector<StandBase>& nominal);

// By sample: 1 or -1 where the torque holds the teeth on one side; 0 where it does not, or changes at a neighbouring
// sample. A released link needs time to cross the gap.
std::vector<int> find_sides(const std::vector<double>& torque, double slack);

// True if a torque holds a joint on the side of `offset` [rad] in every recording and never on the other side. Then the
// offset may be half of a gap.
bool may_be_play(const StandProblem& problem, const std::vector<StandBase>& evaluation, size_t joint, double offset);

// Channels [sample][channel], flat, with the link in the middle of the teeth and kSlopeStep aside. The first `geometry`
// of them depend on the feet; those from index `places` are known except for a constant.
struct PlayRows {
  const std::vector<double>&middle, &aside;
  size_t channels, geometry, places;
};

// Position [rad] of the link in a gap, by sample.
std::vector<double> place_within_play(const PlayRows& rows, const std::vector<double>& noise,
                                      const std::vector<int>& sides, double gap);

}  // namespace hrp::diagnosis::standing
