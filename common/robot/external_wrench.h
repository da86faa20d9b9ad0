// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/spatial/transform.h"

namespace hrp {

// A push on one link, in addition to everything that a simulator computes.
struct ExternalWrench {
  int link = 0;
  Vector6d F_W = Vector6d::Zero();  // [N m; N] moment about the link frame's origin, force; world axes
};

using ExternalWrenches = std::vector<ExternalWrench>;

}  // namespace hrp
