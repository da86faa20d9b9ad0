// SPDX-License-Identifier: BSD-3-Clause
// Other effects that explain about as much in the place of one that was found.
#pragma once

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// `rest`: what was chosen without the effect that was found.
std::vector<Rival> list_rivals(const SearchState& state, const LeggedFit& rest, const FoundEffect& found);

}  // namespace hrp::diagnosis::floating
