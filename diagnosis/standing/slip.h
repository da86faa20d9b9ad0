// SPDX-License-Identifier: BSD-3-Clause
// How slippery the ground was, seen from the feet.
#pragma once

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// Friction (find_asked_friction()) at which the feet of the recordings were seen to slip: densest half of the
// samples in which they moved against each other, and half its width. False when nothing slipped, or at values that
// scatter.
bool find_slip_ratio(const StandProblem& problem, double* ratio, double* spread);

// Friction that a foot on the ground asks for: its force along the ground and its moment about where the ground presses
// on it, together, over the vertical force. Against turning a sole is taken to hold as much as if it pressed evenly: at
// its corners alone it would hold twice that, but how it presses is not known.
double find_asked_friction(const StandFoot& foot, const Vector3d& force, const Vector3d& torque, double vertical);

// [m] What feet at rest seem to move from sample to sample: noise of encoders, the same in all recordings, so that the
// one with the quietest quarter of samples tells; in others the feet may creep all the time. By recording; -1: unknown.
double find_rest(const std::vector<std::vector<double>>& slides);

}  // namespace hrp::diagnosis::standing
