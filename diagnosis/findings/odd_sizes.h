// SPDX-License-Identifier: BSD-3-Clause
// An effect of a size that no machine has stands for something else: its law fits, its value says that it is not the cause.
#pragma once

#include <nlohmann/json.hpp>

#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// Why a value is hardly possible on this robot, empty where it is possible:
// - a mass, an inertia or a torque constant that is wrong by more than a factor of e (sensors may log in any unit);
// - a centre of mass further off than the link reaches (calc_link_reach), a load half a metre further;
// - a constant force of more than three times the weight of all that moves;
// - a load heavier than all that moves, twice.
std::string find_odd_size(const TreeSpec& tree, const nlohmann::ordered_json& finding);

// Findings of an odd size become `ambiguous` and say so. What was `certain` beside them becomes `ambiguous`, too, because
// it is certain only as a part of a whole that explains everything; `explained` becomes `mostly_explained`.
void doubt_odd_sizes(const TreeSpec& tree, nlohmann::ordered_json* report);

// A sole that sinks by less than a millimetre under half the robot's weight, and tilts by less than 5 mrad when the force on
// it moves by 5 cm, is as stiff as floors, force sensors and the contacts of simulators are: where the give sits is not told,
// and the finding becomes `ambiguous`.
void doubt_stiff_soles(const TreeSpec& tree, nlohmann::ordered_json* report);

// Findings whose value is less than a quarter of a standard deviation from none say nothing. They are left out of the report, not of
// the model, as long as another finding stays.
void drop_idle_findings(nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
