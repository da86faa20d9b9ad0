// SPDX-License-Identifier: BSD-3-Clause
// Explanations with values that the recordings allow as well: a motion must be safe under these, too.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// The explanation with one value after the other at either end of its 95 % interval. `fisher`: information of the
// recordings about its fitted parameters. Values that nothing is known of move by half of themselves. Effects that `looked_at`
// has as well stay: their ends were looked at with it.
std::vector<Hypothesis> list_ends(const Hypothesis& hypothesis, const Eigen::MatrixXd& fisher, const Hypothesis& looked_at = {});

}  // namespace hrp::diagnosis
