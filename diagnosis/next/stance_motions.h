// SPDX-License-Identifier: BSD-3-Clause
// Motions of a robot on its feet: the soles stay in place while the body moves, or the robot walks.
#pragma once

#include <vector>

#include "diagnosis/next/motions.h"

namespace hrp::diagnosis {

// An unsafe size is reduced by this factor, down to the least one.
constexpr double kSmallerStance = 0.6, kLeastStance = 0.2;

// Motions of these families for a robot with so many joints: several sines, held postures, and slow sines, because the
// zero-moment point bears a larger sway if it is slow. Of walks two gaits.
std::vector<MotionPlan> list_stance_plans(const std::vector<Family>& families, size_t joints, double seconds);

// Commands of all joints for a sway, lean, squat, swing or walk by `plan.size` of the usual amplitude. `plan.moves`:
// joints that carry no foot and swing as well; empty: none. No samples if a leg cannot reach, if a joint would exceed
// the limits of its commands, or if nothing moves.
Commands make_stance_motion(const Experiment& experiment, const MotionPlan& plan, const Limits& limits);

}  // namespace hrp::diagnosis
