// SPDX-License-Identifier: BSD-3-Clause
// What a report says of each effect that was chosen: values, deviations, gain, share and rivals.
#pragma once

#include "diagnosis/floating/search/state.h"

namespace hrp::diagnosis::floating {

// In the order of the chosen effects; of the fit to the fitted rows.
std::vector<FoundEffect> describe_effects(const SearchState& state);

// What recordings decide, all of them measure: puts the values of a fit to all rows into effects that are named. Gains
// and shares stay those of a fit that has not seen the held-out rows. An effect keeps its values if all rows together
// leave a parameter untold: what is left of two columns without their noise can be alike.
void measure_by_all(const SearchState& state, std::vector<FoundEffect>* effects);

}  // namespace hrp::diagnosis::floating
