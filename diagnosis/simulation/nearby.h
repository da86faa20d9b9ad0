// SPDX-License-Identifier: BSD-3-Clause
// How far dry friction lets a joint bend before it slips. Readings are no smooth function of it, so values are tried.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// [rad] tried where nothing is known: from what only rounds the corner of a step to the wind-up of a gear.
constexpr double kPreslidings[] = {3e-6, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3};

// The hypothesis with the displacements that suit the training recordings best: from each as it stands by factors of 3,
// 1.5, 1.2 and 1.06 in both directions, within its bounds, as long as that helps. Off by more, what a fit then lacks
// near standstill is made up for by friction that seems to fall with speed.
Hypothesis choose_presliding(const Problem& problem, Hypothesis best);

}  // namespace hrp::diagnosis
