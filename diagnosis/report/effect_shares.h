// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "diagnosis/model/effect.h"

namespace hrp::diagnosis {

// Share of the held-out squares above the noise that each effect of a model takes away (estimate/shapley.h).
// `calc_left`: what a part of the model leaves, root mean square [times the noise]; `nominal`: what no effect leaves.
std::vector<double> calc_effect_shares(const Hypothesis& model, double nominal,
                                       const std::function<double(const Hypothesis&)>& calc_left);

}  // namespace hrp::diagnosis
