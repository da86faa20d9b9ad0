// SPDX-License-Identifier: BSD-3-Clause
// Scans parameters that readings do not depend on smoothly: pre-sliding displacement of dry friction, and the width of
// a gap.
#pragma once

#include "diagnosis/search/fit.h"

namespace hrp::diagnosis {

// [rad] Pre-sliding displacements to try if nothing is known: from one that only rounds a step to the wind-up of a
// gear.
constexpr double kPreslidings[] = {3e-6, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3};

constexpr double kFinestFactor = 1.06;
// The finest factor where a coarse scan does: before a fit, and far from the noise.
constexpr double kCoarseFactor = 1.5;

// Scales these parameters by factors of 3, 1.5, 1.2 and 1.06 in both directions, within their bounds, as long as the
// fit of the training recordings improves. For pre-sliding displacements, factors below `finest` are left out. With a
// wrong displacement, a fit compensates by friction that decreases with speed. With a wrong gap, each impact is at the
// wrong time, and a gradient does not lead to the right one.
Hypothesis try_nearby(const Problem& problem, Hypothesis best, double finest = kFinestFactor);

}  // namespace hrp::diagnosis
