// SPDX-License-Identifier: BSD-3-Clause
// Takes out effects that the growth chose and that a report must not claim. Each rule takes out one effect at a time,
// because the others may look different without it.
#pragma once

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// A law has one size in all regimes: in each phase of walking, in calm and in rough rows. Of the effects that have not,
// the one with the smallest gain goes. False: there is none.
bool drop_unsteady(SearchState* state);

// Drops by the rules that need the description of what was chosen. False: all effects hold.
bool drop_doubtful(const std::vector<FoundEffect>& found, SearchState* state);

}  // namespace hrp::diagnosis::floating
