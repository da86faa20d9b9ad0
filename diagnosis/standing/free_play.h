// SPDX-License-Identifier: BSD-3-Clause
// Where the link behind a loose transmission lies between the teeth. A torque holds it on one side; else it is free
// within the gap, and the feet, which stand, tell where it is.
#pragma once

#include <vector>

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

struct StandBase;

using TeethOffsets = std::vector<std::vector<double>>;  // [rad] by joint, by sample; empty where nothing is loose
constexpr double kTeethStep = 1e-4;                     // [rad] for slopes; the feet's places are as good as linear

// [N m] By joint: a torque that is this large is no noise.
std::vector<double> find_slack(const StandProblem& problem, const std::vector<StandBase>& nominal);

// By sample: 1 or -1 where the torque holds the teeth on one side, 0 where it does not or is about to change: a link
// that is let go takes its time to cross the gap.
std::vector<int> find_sides(const std::vector<double>& torque, double slack);

// Whether a torque holds a joint on the side of an offset [rad] in every recording and never on the other one: then the
// offset may be half of a gap.
bool may_be_play(const StandProblem& problem, const std::vector<StandBase>& evaluation, size_t joint, double offset);

// What the channels say with the link in the middle of the teeth and kTeethStep aside, [sample][channel], flat. The
// first `geometry` of them follow the feet; those from `places` on are known but for a constant.
struct TeethRows {
  const std::vector<double>&middle, &aside;
  size_t channels, geometry, places;
};

// [rad] By sample, where the link lies in a gap.
std::vector<double> place_teeth(const TeethRows& rows, const std::vector<double>& noise, const std::vector<int>& sides,
                                double gap);

}  // namespace hrp::diagnosis::standing
