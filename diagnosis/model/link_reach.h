// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// [m] from a link's frame, within which something may hang on it: twice to its centre of mass, its children's joints or
// its fixed frames, and a hand's width.
double calc_link_reach(const TreeSpec& tree, int link);

// [m] The same of the centre of mass of what the link carries: half a metre more, as an object in a hand is long.
double calc_carried_reach(const TreeSpec& tree, int link);

}  // namespace hrp::diagnosis
