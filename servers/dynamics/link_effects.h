// SPDX-License-Identifier: BSD-3-Clause
// Effects of a link: changes of the tree, and forces that always act. The simulator has them, the robot's description
// (and so the controller) does not.
#pragma once

#include <vector>

#include "common/multibody/tree_spec.h"
#include "common/robot/scenario.h"

namespace hrp {

// external_force {force [N], world axes}: at the link's centre of mass, all the time.
struct SteadyForce {
  int link = 0;
  Vector3d p_LQ = Vector3d::Zero();  // [m]
  Vector3d force_W = Vector3d::Zero();
};

// Puts Scenario::link_laws into the tree and returns the forces among them. A foot with a bush is two links, above it
// and the sole: mass_error and com_error go to both, a payload to the one above. A link that is lumped into another
// may carry a payload or get a force; its own mass is no longer known. Throws InputError.
std::vector<SteadyForce> apply_link_laws(const Scenario& scenario, TreeSpec* tree);

}  // namespace hrp
