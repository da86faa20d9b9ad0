// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/multibody/tree_spec.h"

namespace hrp {

// [kg] Of all links.
inline double calc_mass(const TreeSpec& tree) {
  double mass = 0.0;
  for (const LinkSpec& link : tree.links) mass += link.inertia.mass;
  return mass;
}

}  // namespace hrp
