// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {

// What is claimed when the single law cannot be: "dry friction" of "coulomb_friction". What is in no row of the table is a zero.
std::string find_family_name(const std::string& effect);

// The one effect of a family at places of a kind: a sensor's gain. There must be just one.
const EffectInfo& get_effect_of(PlaceKind place, EffectFamily family);

// Whether a report's name is that of a row.
bool is_effect(const std::string& name, EffectId id);

}  // namespace hrp::diagnosis
