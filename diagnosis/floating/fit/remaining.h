// SPDX-License-Identifier: BSD-3-Clause
// Which equations of a robot on its feet keep a mismatch that a model leaves.
#pragma once

#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/floating/fit/least_squares.h"

namespace hrp::diagnosis::floating {

// Held-out rows, or those that were fitted where an equation has no others.
Part find_judged_part(const LeggedFitter& fitter, size_t channel);

// [unit^2] Of an equation, beyond noise, on these rows.
double get_mean_square(const LeggedFitter& fitter, const LeggedFit& fit, size_t channel);

// Something is left that could be predicted, that is far beyond its noise, or as large as the signal itself.
bool is_left(const LeggedFitter& fitter, const LeggedFit& fit, size_t channel);

// Feet roll over their edges and lie a little askew: no mismatch by itself.
bool is_of_soles(const ChannelInfo& info);

// The largest first: what the model leaves, of what it has changed, too, and `unsteady` equations, which effects helped
// that were not of one size. What is less than models are exact to is nothing.
std::vector<Remaining> list_remaining(const LeggedFitter& fitter, const LeggedFit& nominal, const LeggedFit& model,
                                      const std::vector<size_t>& unsteady);

}  // namespace hrp::diagnosis::floating
