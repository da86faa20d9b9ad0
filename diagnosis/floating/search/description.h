// SPDX-License-Identifier: BSD-3-Clause
// What a report says of each effect that was chosen: values, deviations, gain, share and rivals.
#pragma once

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// In the order of the chosen effects.
std::vector<FoundEffect> describe_effects(const SearchState& state);

}  // namespace hrp::diagnosis::floating
