// SPDX-License-Identifier: BSD-3-Clause
// Models under which a motion of a robot with many effects must be safe.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/next/open_terms.h"

namespace hrp::diagnosis {

struct TorqueWorld {
  std::string label;  // "under the nominal model"
  TorqueSide side;
  double end = 0.0;  // -1, 1: all values at the lower or upper ends of their intervals
};

// The nominal model; the report's; the same with all values at either end; the rivals of `questions`.
std::vector<TorqueWorld> list_torque_worlds(const OpenTerms& terms, const std::vector<size_t>& questions);

}  // namespace hrp::diagnosis
