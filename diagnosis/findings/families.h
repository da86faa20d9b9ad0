// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {

// Family that is claimed if the single law is uncertain: "dry friction" of "coulomb_friction"; "zero" for unknown
// effects.
std::string find_family_name(const std::string& effect);

// The effect of a family at a kind of place, such as the scale of a sensor. There must be exactly one.
const EffectInfo& get_effect_of(PlaceKind place, EffectFamily family);

// The fault of a reading that comes late: it adds in proportion to the reading's rate.
const EffectInfo& get_late_reading();

// Friction of constant level, of the dry frictions of a joint.
const EffectInfo& get_constant_friction();

}  // namespace hrp::diagnosis
