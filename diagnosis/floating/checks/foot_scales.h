// SPDX-License-Identifier: BSD-3-Clause
// Scales of single feet's force sensors, by what the feet carry in each phase of a walk: a mass shows in all phases, a
// scale with what its foot bears.
#pragma once

#include <map>
#include <vector>

#include "diagnosis/floating/checks/checks.h"

namespace hrp::diagnosis::floating {

struct FootScale {
  size_t foot = 0;
  double scale = 1, std = 0;  // [1]
  double left = 1;  // share that it leaves of what a mass leaves of the phases, in squares; each phase counts alike
};

// Best first, those that leave less than a mass does. `phases`: what the feet carry over what the model weighs, by the
// feet that are loaded (bits). Each foot alone and all of them have to be there; empty where they are not.
std::vector<FootScale> list_foot_scales(const std::map<int, Consensus>& phases, size_t feet);

// Lists the scales among the alternatives of a weight's finding. Where a foot's scale leaves a quarter of what a mass
// leaves, it becomes the finding, and the mass an alternative: then true. `motion`: that would tell.
bool take_foot_scale(const LeggedLog& log, const std::vector<FootScale>& scales, const char* motion, Finding* weight);

}  // namespace hrp::diagnosis::floating
