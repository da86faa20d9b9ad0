// SPDX-License-Identifier: BSD-3-Clause
// Loads to hang on a fixed-base robot. A known weight distinguishes a wrong torque constant from a wrong mass.
#pragma once

#include <vector>

#include "common/multibody/tree_spec.h"
#include "common/robot/experiment_keys.h"

namespace hrp::diagnosis {

// One load for the last link of each limb, at its centre of mass: 0.1, 0.2, 0.5, 1, 2 or 5 kg, weights that people
// have. `most` [kg]: largest load; 0: none.
std::vector<LoadSpec> list_hung_loads(const TreeSpec& tree, double most);

// "Hang 1 kg on fore, its centre at (0.15, 0, 0) m in the link's frame."
std::string describe(const LoadSpec& load);

}  // namespace hrp::diagnosis
