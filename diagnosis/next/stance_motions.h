// SPDX-License-Identifier: BSD-3-Clause
// Motions of a robot that stands: the soles stay where they are, the body moves over them.
#pragma once

#include <vector>

#include "diagnosis/next/motions.h"

namespace hrp::diagnosis {

// A size that is not safe is made smaller by this factor, down to the least.
constexpr double kSmallerStance = 0.6, kLeastStance = 0.2;

// Commands of all joints so that the body sways, leans or squats by `plan.size` of what is usual. `plan.moves` is not
// looked at. No samples where a leg does not reach, or a joint would pass the limits of its commands.
Commands make_stance_motion(const Experiment& experiment, const MotionPlan& plan, const Limits& limits);

}  // namespace hrp::diagnosis
