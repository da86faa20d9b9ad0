// SPDX-License-Identifier: BSD-3-Clause
// The motions that are tried for a robot on a fixed base.
#pragma once

#include <vector>

#include "diagnosis/next/limits.h"
#include "diagnosis/next/motions.h"
#include "diagnosis/simulation/plant.h"

namespace hrp::diagnosis {

// Factor on the worth of a motion with a drawback: it needs a load hung on by hand, or is the second of its family,
// which may miss the same effects.
constexpr double kDrawback = 0.9;

// Marks the joints at which effects act, and the joints that carry such links. `moves`: by joint.
void mark_concerned(const Experiment& experiment, const Hypothesis& hypothesis, std::vector<char>* moves);

// Makes the joints smaller that passed their own limits; all of them if none did (a collision), or if these are small
// already. `faulty`: by joint. Returns false if the motion would be smaller than the least size.
bool make_smaller(const std::vector<char>& faulty, MotionPlan* plan);

// Every family with all joints and with those in `concerned` alone; slow families also with a load by hand.
std::vector<MotionPlan> list_plans(const Experiment& experiment, const Limits& limits,
                                   const std::vector<char>& concerned, double seconds);

}  // namespace hrp::diagnosis
