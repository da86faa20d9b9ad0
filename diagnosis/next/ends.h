// SPDX-License-Identifier: BSD-3-Clause
// Explanations with parameters at the ends of their intervals. A motion must be safe under these as well.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// The explanation with one parameter at a time at either end of its 95 % interval. `fisher`: information of the
// recordings about the fitted parameters. Parameters without information change by half of their value. Skips effects
// that `looked_at` contains: their ends were checked with it.
std::vector<Hypothesis> list_ends(const Hypothesis& hypothesis, const Eigen::MatrixXd& fisher,
                                  const Hypothesis& looked_at = {});

}  // namespace hrp::diagnosis
