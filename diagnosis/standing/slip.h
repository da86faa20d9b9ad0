// SPDX-License-Identifier: BSD-3-Clause
// Estimates the friction of the ground from feet that slip.
#pragma once

#include "diagnosis/standing/data.h"

namespace hrp::diagnosis::standing {

// Finds the friction coefficient (find_asked_friction()) at which feet slipped. `ratio`: mean of the densest half of
// the samples in which the feet moved relative to each other; `spread`: half the width of that half. Returns false if
// nothing slipped, the values scatter by more than a fifth, or the ratio is not below the stated friction.
bool find_slip_ratio(const StandProblem& problem, double* ratio, double* spread);

// Friction coefficient that a foot needs: tangential force and moment about its pressure point, combined, over the
// vertical force [N]. A flat sole is assumed to press evenly. If it pressed at its corners alone, it would resist twice
// the turning moment, but the distribution is unknown.
double find_asked_friction(const StandFoot& foot, const Vector3d& force, const Vector3d& torque, double vertical);

// Apparent motion [m] of resting feet from sample to sample, caused by encoder noise. The noise is the same in all
// recordings, so the recording with the smallest lower quartile determines it; in others the feet may creep. `slides`
// [m]: by recording, by sample; -1: unknown.
double find_rest(const std::vector<std::vector<double>>& slides);

}  // namespace hrp::diagnosis::standing
