// SPDX-License-Identifier: BSD-3-Clause
// What a fitted effect says by its parameters alone.
#pragma once

#include <vector>

#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Does an effect differ from its absence by four standard deviations (std: of its parameters; distance: of all of them
// at once, which counts for vectors)? A transmission must give within bounds; what has no absent value (saturation, a
// Stribeck curve) always does.
bool is_significant(const Effect& effect, const std::vector<double>& std, double distance);

// Friction with a dry part of its own: there is one of these in a joint.
bool is_dry(EffectId id);

// Dry friction, also in proportion to the load: readings are a jagged function of it, and coarse steps miss it.
bool sticks(EffectId id);

// [kg m^2] of a rotor, also behind a transmission; 0 for other effects.
double get_rotor(const Effect& effect);

// A rotor that nothing parts from its link.
bool is_rigid_rotor(const Effect& effect);

// Without friction, memory, play or limits.
bool is_smooth(const Hypothesis& hypothesis);

// Phases between 0 and 2 pi, amplitudes positive.
void normalise(Hypothesis* hypothesis);

}  // namespace hrp::diagnosis
