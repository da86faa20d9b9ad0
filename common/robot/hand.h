// SPDX-License-Identifier: BSD-3-Clause
// A hand that holds a point Q of a link and moves: the laws of HandSpec, one hand at a time.
#pragma once

#include "common/robot/scenario.h"

namespace hrp {

// Of the hand H against where it took hold, world axes.
struct HandPlace {
  Vector3d p = Vector3d::Zero();  // [m]
  Vector3d v = Vector3d::Zero();  // [m/s]
};

// The way along the path and the waves, `time` [s] after the hand took hold. v is the derivative of p.
HandPlace calc_hand_place(const HandSpec& hand, double time);

// Force of the hand on the link at Q [N, world axes]: K (p_QH) + C (v_H - v_Q), towards the hand; axis by axis.
// p_QH from the point held to the hand [m], v_QH velocity of the hand against the point [m/s].
Vector3d calc_hand_force(const HandSpec& hand, const Vector3d& p_QH, const Vector3d& v_QH);

}  // namespace hrp
