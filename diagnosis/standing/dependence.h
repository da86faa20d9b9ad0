// SPDX-License-Identifier: BSD-3-Clause
// Finds what the residual of a channel depends on if no known effect explains it.
#pragma once

#include "diagnosis/search/relation.h"
#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

// Dependence on position, velocity, direction, load and time, and on positions of other joints.
Relation find_dependence(const StandProblem& problem, const Channel& channel, size_t index,
                         const Evaluation& evaluation);

// True if the residual of a joint's effort follows the position of another joint (half of its squares), beside its own
// position. Then something couples the two.
bool follows_joint(const StandProblem& problem, const Channel& channel, size_t index, const Evaluation& evaluation,
                   int other);

// True if the residuals of two effort channels are equal, or with sense -1 equal and opposite.
bool are_equal(const Evaluation& evaluation, size_t channels, size_t a, size_t b, double sense);

// Two joints: indices of their effort channels, joint indices, noise of the channels [N m].
struct SpringPair {
  size_t channels[2];
  int joints[2];
  double noise[2];
};

// n ln(squares left by one spring across two joints / squares left by a spring in each). The one spring acts on the sum
// or the difference of the positions. Small values mean that one spring explains as much as two.
double calc_spring_gain(const StandProblem& problem, const Evaluation& evaluation, const SpringPair& pair);

// n ln(squares left by dry friction / squares left if its level may be a parabola of the joint's position). Fitted to
// training recordings, evaluated on held-out ones; 0 with too few samples.
double calc_uneven_gain(const StandProblem& problem, const Evaluation& evaluation, size_t channel, size_t joint);

// True if 70 % of a channel's squares is one sinusoid of time, with any amplitude and phase in each recording.
bool follows_time(const StandProblem& problem, const Channel& channel, size_t index, const Evaluation& evaluation);

}  // namespace hrp::diagnosis::standing
