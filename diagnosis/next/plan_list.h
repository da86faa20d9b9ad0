// SPDX-License-Identifier: BSD-3-Clause
// The motions that are tried for a robot on a fixed base.
#pragma once

#include <vector>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/motions.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Marks the joints at which effects act, and the joints that carry such links. `moves`: by joint.
void mark_concerned(const Experiment& experiment, const Hypothesis& hypothesis, std::vector<char>* moves);

// Every family with all joints and with those in `concerned` alone; slow families also with a load by hand.
std::vector<MotionPlan> list_plans(const Experiment& experiment, const Limits& limits, const std::vector<char>& concerned, double seconds);

}  // namespace hrp::diagnosis
