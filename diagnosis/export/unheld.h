// SPDX-License-Identifier: BSD-3-Clause
// What of a joint's laws a format cannot hold, in words.
#pragma once

#include <string>
#include <vector>

#include "common/effects/joint_law.h"
#include "common/multibody/tree_spec.h"

namespace hrp::diagnosis {

// What a format holds beside viscous and dry friction.
struct Holds {
  bool rotor = false, gain = false, spring = false, delay = false, static_friction = false;
};

// "dry friction is 0.31 N m at rest and falls to 0.2 N m above 0.05 rad/s", ...; empty when all is held.
std::vector<std::string> list_unheld(const JointSpec& joint, const JointLaws& laws, const Holds& holds);

// [N m or N] Largest true torque. The limit of the logged effort is the servo's, or the joint's where it has none, as
// in the simulator; the gain comes after it.
double find_torque_limit(const JointSpec& joint, const JointLaws& laws);

// A link's name in formats that keep "world" for the world: arms are often bolted to a link of that name.
std::string name_link(const TreeSpec& tree, int link);

// Moving links without mass, such as those between two joints of a cardan joint, get these: MuJoCo refuses 0, and SDF
// takes 1 kg where nothing is stated.
constexpr double kLeastMass = 1e-9, kLeastInertia = 1e-12;  // [kg], [kg m^2]

// A line of XML; comments must not hold two hyphens in a row.
std::string make_comment(const std::string& text);

// Six digits: what recordings tell, and what a reader can read.
std::string print_value(double value);

}  // namespace hrp::diagnosis
