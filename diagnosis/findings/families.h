// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {

// What is claimed when the single law cannot be: "dry friction" of "coulomb_friction". What is in no row of the table (a constant torque, a tilted base) is a zero.
std::string find_family_name(const std::string& effect);

// Whether a report's name is that of a row.
bool is_effect(const std::string& name, EffectId id);

}  // namespace hrp::diagnosis
