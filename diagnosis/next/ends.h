// SPDX-License-Identifier: BSD-3-Clause
// Explanations with values that the recordings allow as well: a motion must be safe under these, too.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// The explanation with one value after the other at either end of its 95 % interval. `fisher`: information of the
// recordings about its fitted parameters. Values that nothing is known of move by half of themselves.
std::vector<Hypothesis> list_ends(const Hypothesis& hypothesis, const Eigen::MatrixXd& fisher);

}  // namespace hrp::diagnosis
