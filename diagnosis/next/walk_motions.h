// SPDX-License-Identifier: BSD-3-Clause
// Walks of a robot on two feet: the pattern of the walking controller, played without its sensors.
#pragma once

#include "diagnosis/next/motions.h"

namespace hrp::diagnosis {

// True if a foot leaves the ground in the recordings and comes back.
bool is_walking(const Experiment& experiment);

// Positions of all joints for steps forward and as many back, from the start pose to the start pose, with the body
// lowered by `lowered` [m]. `plan.size` scales the length of a step; an even seed makes short quick steps, an odd one
// long slow ones. No samples without two legs of six joints, if a leg does not reach, or if `plan.seconds` are too
// short for three steps.
Commands make_walk(const Experiment& experiment, const MotionPlan& plan, const Limits& limits, double lowered);

}  // namespace hrp::diagnosis
