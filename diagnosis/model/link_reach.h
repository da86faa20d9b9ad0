// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// [m] from a link's frame, within which something may hang on it: twice to its centre of mass, its children's joints or
// its fixed frames, and a hand's width.
double calc_link_reach(const TreeSpec& tree, int link);

}  // namespace hrp::diagnosis
