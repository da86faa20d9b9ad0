// SPDX-License-Identifier: BSD-3-Clause
// Parameters from the missing torque, once more by simulation: each joint alone, all others as recorded.
#pragma once

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// The model with parameters of each joint's effects fitted to the training recordings through the simulation of that
// joint; kept as they were where that predicts the training recordings no better. Effects of links stay.
Hypothesis polish_joints(const Problem& problem, const Hypothesis& model);

// Dry friction of level L that is larger one way, L (1 + a) and L (1 - a), is friction L and a constant torque L a, which
// a scenario can state.
Hypothesis split_asymmetry(const Hypothesis& model);

}  // namespace hrp::diagnosis
