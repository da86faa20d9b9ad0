// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// Whether a link carries another one, or is it.
bool is_above(const TreeSpec& tree, int link, int carried);

// Whether a link carries no other.
bool is_last(const TreeSpec& tree, int link);

}  // namespace hrp::diagnosis
