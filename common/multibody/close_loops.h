// SPDX-License-Identifier: BSD-3-Clause
// Poses in which closed chains are closed: how far open loops are, and the joint positions that close them.
#pragma once

#include <vector>

#include "common/multibody/loops.h"

namespace hrp {

// Between frames A and B of a loop, in the directions that its kind keeps.
struct LoopGap {
  double length = 0.0;  // [m]
  double angle = 0.0;   // [rad]
};

// Of each loop in the pose of `state`.
std::vector<LoopGap> calc_gaps(const Model& model, const std::vector<LoopConstraint>& loops, const State& state);

// Moves `joints` of `state` until all loops are closed, or as nearly as they can be: Gauss-Newton from the given
// positions, each step the shortest one. Of two ways to assemble a linkage it finds the one nearby. What is left,
// calc_gaps() says.
void close_loops(const Model& model, const std::vector<LoopConstraint>& loops, const std::vector<int>& joints,
                 State* state);

}  // namespace hrp
