// SPDX-License-Identifier: BSD-3-Clause
// Loops of a robot, from its description (<loop>) or its scenario (`loops`): from names to frames.
#pragma once

#include <string>
#include <vector>

#include "common/multibody/loops.h"
#include "common/robot/scenario.h"

namespace hrp {

// A chain counts as closed up to this: then the poses were meant to fit and were rounded.
constexpr double kOpenLoop = 5e-3;  // [m, rad]

// The scenario's loops with the links that carry their frames. Throws InputError for a link that is not there, and for
// a loop with both ends on one moving link.
std::vector<LoopConstraint> find_loops(const TreeSpec& tree, const Scenario& scenario);

// Joints that may move to close a loop in the start pose: without a drive, no mimic joint, no joint of a foot's bush.
std::vector<int> find_passive_joints(const TreeSpec& tree);

// A scenario's text with these loops added to its section `loops`: YAML that reads as before otherwise.
std::string add_loops(const std::string& text, const std::vector<LoopSpec>& loops);

// `scenario` with the loops and the closed start pose that the model parser wrote into the text it hands on, `merged`.
// Positions that `scenario` gives itself stay.
Scenario adopt_loops(const Scenario& scenario, const std::string& merged);

}  // namespace hrp
