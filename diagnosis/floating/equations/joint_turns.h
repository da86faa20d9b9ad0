// SPDX-License-Identifier: BSD-3-Clause
// How far links may be from where their encoders say. Equations are differenced by small turns of each joint: about its
// own axis, and, where the structure that carries it may bend, about two axes across it.
#pragma once

#include <utility>

#include "diagnosis/floating/fit/columns.h"
#include "diagnosis/model/tree.h"

namespace hrp::diagnosis::floating {

// Of a joint: how far its encoder's side is ahead of its link's, by a gap of 1 rad, by a give of 1 rad/(N m) about its
// axis, and by one of the structure about each of the two axes across.
struct JointSides {
  double play = 0, give = 0, bend[2] = {0, 0};
};

// A turn about axis 0 (the joint's own), 1 or 2, and the columns that are a factor times what the turn changes.
struct JointTurn {
  int joint = 0, axis = 0;
  std::vector<std::pair<int, double>> columns;
};

// Whether all that the joint passes on is known, so that the moment about other axes than its own is: a leg that ends
// in a sensor of six axes.
bool may_bend(const LeggedLog& log, int joint);

// The turns of all joints whose positions were recorded. Any sides: the columns are the same.
std::vector<JointTurn> list_turns(const LeggedLog& log, const ColumnLayout& layout,
                                  const std::vector<JointSides>& sides);
std::vector<int> list_turn_columns(const LeggedLog& log, const ColumnLayout& layout);

// A unit axis across a joint's own (1 or 2), in the joint's frame.
Vector3d get_cross_axis(const JointSpec& joint, int axis);

}  // namespace hrp::diagnosis::floating
