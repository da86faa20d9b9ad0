// SPDX-License-Identifier: BSD-3-Clause
// Units of a joint's quantities. The table of effects states those of a joint that turns.
#pragma once

#include <string>

#include "common/effects/effect_info.h"
#include "common/multibody/tree_spec.h"

namespace hrp {

// The unit of the same quantity at this joint: "N m" at one that turns is "N" at one that slides.
std::string get_joint_unit(const JointSpec& joint, const std::string& unit);
std::string get_joint_unit(const JointSpec& joint, const EffectParameter& parameter);

}  // namespace hrp
