// SPDX-License-Identifier: BSD-3-Clause
// Parameters from the missing torque, once more by simulation: each joint alone, all others as recorded.
#pragma once

#include "diagnosis/evidence/effort_rows.h"
#include "diagnosis/evidence/joint_alone.h"

namespace hrp::diagnosis {

// The model with parameters of each joint's effects fitted to the training recordings through the simulation of that
// joint; kept as they were where that predicts the training recordings no better. Effects of links stay.
// With `enriched`, laws that a drive may have beside (a Stribeck curve, a lag, a late command, another gain) are added
// where they take away a few percent of what the joint's simulation leaves.
// With `efforts`, both the joint's simulation and its efforts count.
Hypothesis polish_joints(const Problem& problem, const Hypothesis& model, const EffortRows* efforts = nullptr, bool enriched = false);

// The same once more of the whole robot, a few steps: recorded motions of the other joints, by which a joint alone is
// simulated, have the noise of their encoders. The model as it is where that would be too long.
Hypothesis polish_whole(const Problem& problem, const Hypothesis& model, const CalcResiduals& residuals, int iterations);

// What a hypothesis leaves of readings that are simulated over short windows. The problem must outlive it.
CalcResiduals make_window_residuals(const Problem& problem);

// Dry friction of level L that is larger one way, L (1 + a) and L (1 - a), is friction L and a constant torque L a, which
// a scenario can state.
Hypothesis split_asymmetry(const Hypothesis& model);

}  // namespace hrp::diagnosis
