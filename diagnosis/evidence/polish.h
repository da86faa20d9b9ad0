// SPDX-License-Identifier: BSD-3-Clause
// Parameters from the missing torque, once more by simulation: each joint alone, all others as recorded.
#pragma once

#include "diagnosis/search/problem.h"

namespace hrp::diagnosis {

// The model with parameters of each joint's effects fitted to the training recordings through the simulation of that
// joint; kept as they were where that predicts the training recordings no better. Effects of links stay.
// With `enriched`, laws that a drive may have beside (a Stribeck curve, a lag, a late command, another gain) are added
// where they take away a few percent of what the joint's simulation leaves.
Hypothesis polish_joints(const Problem& problem, const Hypothesis& model, bool enriched = false);

// The same once more through the simulation of the whole robot, a few steps: recorded motions of the other joints, by which
// a joint alone is simulated, have the noise of their encoders. The model as it is where that would be too long.
Hypothesis polish_whole(const Problem& problem, const Hypothesis& model);

// Dry friction of level L that is larger one way, L (1 + a) and L (1 - a), is friction L and a constant torque L a, which
// a scenario can state.
Hypothesis split_asymmetry(const Hypothesis& model);

}  // namespace hrp::diagnosis
