// SPDX-License-Identifier: BSD-3-Clause
// What the parameters of a fitted effect imply, without its fit.
#pragma once

#include <vector>

#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// True if an effect differs significantly from its absence. `std`: of its parameters; `distance`: of all of them
// together, which decides for vectors. An elasticity must be within its bounds. Effects without a neutral value
// (saturation, Stribeck curve) always count as significant.
bool is_significant(const Effect& effect, const std::vector<double>& std, double distance);

// Friction with a Coulomb part; a joint has at most one of these.
bool is_dry(EffectId id);

// Dry friction, also load-dependent: readings depend on it non-smoothly, and coarse steps miss it.
bool sticks(EffectId id);

// Rotor inertia [kg m^2], also behind a transmission; 0 for other effects.
double get_rotor(const Effect& effect);

// True for a rotor that is rigidly connected to its link.
bool is_rigid_rotor(const Effect& effect);

// True without friction, memory, play or limits.
bool is_smooth(const Hypothesis& hypothesis);

// Brings phases to [0, 2 pi) and amplitudes to positive values.
void normalise(Hypothesis* hypothesis);

}  // namespace hrp::diagnosis
