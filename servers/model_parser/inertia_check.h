// SPDX-License-Identifier: BSD-3-Clause
// Is a rotational inertia that of a body? And the nearest one that is.
#pragma once

#include <string>

#include "common/multibody/tree_spec.h"

namespace hrp {

// Empty when the inertia can be that of a rigid body of positive mass: finite, principal moments positive, and none
// larger than the sum of the other two (moments are sums of squares of distances). Otherwise why not, with the values.
std::string find_inertia_fault(const LinkInertia& inertia);

// Raises principal moments, keeping the principal axes, until find_inertia_fault() is content: none below
// mass x (1 mm)^2, and small ones up to the triangle inequality. Mass and centre of mass stay; a mass of zero becomes 1
// g.
LinkInertia repair_inertia(const LinkInertia& inertia);

// The two as one rigid body. The second is given in its own frame C, X_LC its pose.
LinkInertia add_inertias(const LinkInertia& a, const LinkInertia& c, const Transform& X_LC);

}  // namespace hrp
