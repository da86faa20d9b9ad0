// SPDX-License-Identifier: BSD-3-Clause
// Parameters that readings are no smooth function of: how far dry friction lets a joint bend before it slips, and the
// width of a gap in which a rotor rattles. Values are tried.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// [rad] before friction slips, tried where nothing is known: from what only rounds the corner of a step to the wind-up
// of a gear.
constexpr double kPreslidings[] = {3e-6, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3};

constexpr double kFinestFactor = 1.06;

// The hypothesis with those values that suit the training recordings best: from each as it stands by factors of 3, 1.5,
// 1.2 and 1.06 in both directions, within its bounds, as long as that helps; displacements before slipping by no factor
// below `finest`. Where those are off by more, what a fit then lacks near standstill is made up for by friction that
// seems to fall with speed; where a gap is, every rattle comes at another time, and no fit follows the gradient to it.
Hypothesis try_nearby(const Problem& problem, Hypothesis best, double finest = kFinestFactor);

}  // namespace hrp::diagnosis
