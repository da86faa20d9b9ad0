// SPDX-License-Identifier: BSD-3-Clause
// Adds, prunes, exchanges and merges effects until nothing wins any more.
#pragma once

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// Grows what was chosen by effects of the table.
void grow_listed(SearchState* state);

// Tries free laws in the place of each effect, then beside all of them. Free laws can fit a little of everything. So
// they come last, and in the place of an effect they must win clearly. They are also rough, so that no listed effect is
// searched in what they leave.
void grow_free(SearchState* state);

}  // namespace hrp::diagnosis::floating
