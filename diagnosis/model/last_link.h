// SPDX-License-Identifier: BSD-3-Clause
// The last link of a chain about the axis of the joint that turns it.
#pragma once

#include <optional>

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// A link that carries no other, on a turning joint: the direction from the axis to its centre of mass, and that in
// which the centre moves as the joint turns.
struct LastLink {
  Vector3d out, turn;   // in the link's axes
  double length = 0.0;  // [m] from the axis to the centre of mass
};

// Empty if the joint carries more than its link, or if the link's centre of mass lies on the axis.
std::optional<LastLink> find_last_link(const TreeSpec& tree, int joint);

}  // namespace hrp::diagnosis
