// SPDX-License-Identifier: BSD-3-Clause
// How effects change the mass of a link: pure functions.
#pragma once

#include "common/multibody/tree_spec.h"

namespace hrp {

// payload {mass [kg], com [m] in the link's frame}: a body fixed to the link, a point mass unless it has an inertia
// [kg m^2], the same about every axis through its centre. Nothing happens where no mass would be left.
void add_payload(double mass, const Vector3d& p_LP, double inertia_about_centre, LinkInertia* link);
// mass_error {scale}: mass and inertia times scale.
void scale_mass(double scale, LinkInertia* inertia);
// com_error {offset [m]}: adds to the centre of mass, inertia about it unchanged.
void move_centre_of_mass(const Vector3d& offset, LinkInertia* inertia);

}  // namespace hrp
