// SPDX-License-Identifier: BSD-3-Clause
// Effects of a link as changes of the tree. External forces are pushes of Simulator::step; the ground's slope is a
// scenario key.
#pragma once

#include "common/multibody/tree_spec.h"

namespace hrp {

// payload {mass [kg], com [m] in the link's frame}: a point mass fixed to the link.
void add_payload(double mass, const Vector3d& p_LP, LinkInertia* inertia);
// mass_error {scale}: mass and inertia times scale.
void scale_mass(double scale, LinkInertia* inertia);
// com_error {offset [m]}: adds to the centre of mass, inertia about it unchanged.
void move_centre_of_mass(const Vector3d& offset, LinkInertia* inertia);

}  // namespace hrp
