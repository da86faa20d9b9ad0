// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/spatial/transform.h"

namespace hrp {

// A twist or wrench with its angular part times a length or its inverse, so that both parts have one unit.
inline Vector6d scale_angular(const Vector6d& x, double factor) {
  Vector6d scaled = x;
  scaled.head<3>() *= factor;
  return scaled;
}

}  // namespace hrp
