// SPDX-License-Identifier: BSD-3-Clause
// Fits parameters of the missing torque again by simulation, one joint at a time while the others follow the recording.
#pragma once

#include "diagnosis/evidence/effort_rows.h"
#include "diagnosis/evidence/joint_alone.h"

namespace hrp::diagnosis {

// Returns the model with each joint's parameters fitted to the training recordings. A joint keeps its parameters if the
// fit is no better. Effects of links stay. `enriched` tests further laws of the drive (Stribeck curve, lag, command
// delay, rotor, viscous friction, gain) and adds those that remove 3 % of the joint's squared residual. `efforts`, if
// given, adds the effort residuals.
Hypothesis polish_joints(const Problem& problem, const Hypothesis& model, const TorqueData* efforts = nullptr,
                         bool enriched = false);

// The same for the effects `own` of one joint.
Hypothesis enrich(const JointAlone& alone, Hypothesis own, int joint);

// Returns the model with the pre-sliding displacement of each joint's dry friction that fits the training recordings
// best. The missing torque does not show it, because friction is full along almost all of a motion. A simulation does:
// a displacement that is too large lets every stop and every reversal creep. No other parameter changes.
Hypothesis find_preslidings(const Problem& problem, const Hypothesis& model);

// Leaves out ripples of torque over position that the servo's simulation contradicts: it follows the recorded motion of
// the training recordings better without them. A torque on the joint moves the joint; a ripple of the effort's log does
// not. Returns the model unchanged for robots that are driven by recorded efforts.
Hypothesis drop_ripples_of_logs(const Problem& problem, const Hypothesis& model);

// Work of a fit through the whole robot: iterations, parameters, steps of the integrator, and the squares of the joints
// of each independent part. Steps, not samples: a log at 125 Hz takes as long to simulate as one at 1 kHz.
double calc_whole_work(const Problem& problem, const Hypothesis& model, int iterations);

// Fits all parameters again through the whole robot. A joint alone follows recorded paths of its neighbours, which
// contain encoder noise. Returns the model unchanged if this would take too long.
Hypothesis polish_whole(const Problem& problem, const Hypothesis& model, const CalcResiduals& residuals,
                        int iterations);

// Residuals of readings that are simulated over short windows. The problem must outlive the function.
CalcResiduals make_window_residuals(const Problem& problem);

// Friction with the levels L (1 + a) and L (1 - a) equals symmetric friction L and a constant torque L a. A scenario
// can state the second form only.
Hypothesis split_asymmetry(const Hypothesis& model);

}  // namespace hrp::diagnosis
