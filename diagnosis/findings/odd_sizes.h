// SPDX-License-Identifier: BSD-3-Clause
// Finds effects of an implausible size. Such an effect fits, but stands in for another cause.
#pragma once

#include <nlohmann/json.hpp>

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// Reason why a value is hardly possible on this robot; empty if it is possible:
//
// - a mass, inertia or torque constant that is wrong by more than a factor of e (sensors may log in any unit);
// - a centre of mass beyond the link's reach (calc_link_reach), or a load more than half a metre beyond it;
// - a constant force of more than three times the weight of the moving links;
// - a load of more than twice the mass of the moving links;
// - a spring that rests more than a turn beyond the joint's range.
std::string find_odd_size(const TreeSpec& tree, const nlohmann::ordered_json& finding);

// False for a load of more than twice the mass of the moving links.
bool is_possible_load(const TreeSpec& tree, double mass);

// Makes findings of an implausible size `ambiguous` and says why. Other `certain` findings become `ambiguous` as well,
// because they are certain only in a model that explains everything. `explained` becomes `mostly_explained`.
// Alternatives of an implausible size are not listed.
void doubt_odd_sizes(const TreeSpec& tree, nlohmann::ordered_json* report);

// Makes findings of very stiff soles `ambiguous`: less than 1 mm compression under half the robot's weight, and less
// than 5 mrad tilt if that force moves by 5 cm. Floors, force sensors and simulated contacts are as stiff, so the place
// of the compliance is unknown.
void doubt_stiff_soles(const TreeSpec& tree, nlohmann::ordered_json* report);

// Makes limits of a drive's torque `ambiguous` that may be no larger than the dry friction found at the same joint:
// such a drive would not move it, and friction that varies while the joint sticks looks the same.
void doubt_limits_within_friction(nlohmann::ordered_json* report);

// Removes ambiguous findings within a quarter of a standard deviation of neutral from the report, not from the model.
// Where the rest is explained to the noise, also those whose 95 % interval contains neutral, and those that a heavier
// finding at the same place lists as its alternative and that list it as theirs: nothing needs them. (Drives of real
// machines leave more than noise, and there friction and rotors of wide intervals are expected.) Keeps them if no other
// finding remains.
void drop_idle_findings(nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
