// SPDX-License-Identifier: BSD-3-Clause
// What the remainder of a channel depends on, when no known effect explains it.
#pragma once

#include "diagnosis/search/relation.h"
#include "diagnosis/standing/fit.h"

namespace hrp::diagnosis::standing {

// To position, velocity, direction, load and time.
Relation find_dependence(const StandProblem& problem, const Channel& channel, size_t index,
                         const Evaluation& evaluation);

// Whether what is left of a channel of one joint's effort follows the position of another joint, beside its own: then
// something couples the two.
bool follows_joint(const StandProblem& problem, const Channel& channel, size_t index, const Evaluation& evaluation,
                   int other);

// Whether what is left of two efforts (channels of a sample's row) is equal, or with sense -1 equal and opposite.
bool are_equal(const Evaluation& evaluation, size_t channels, size_t a, size_t b, double sense);

// Two joints: channels of their efforts in a sample's row, joints, noise of the channels [N m].
struct SpringPair {
  size_t channels[2];
  int joints[2];
  double noise[2];
};

// n log of the squares that one spring across two joints leaves of their efforts (on the sum or the difference of their
// positions) over those that a spring in each leaves: no more than chance where one explains as much as two.
double calc_spring_gain(const StandProblem& problem, const Evaluation& evaluation, const SpringPair& pair);

// n log of the squares that a dry friction leaves of a drive's effort (its channel in a sample's row) over those that
// it leaves where its level may follow the joint's position: learnt on training recordings, judged on the others.
double calc_uneven_gain(const StandProblem& problem, const Evaluation& evaluation, size_t channel, size_t joint);

// Whether nearly all of a channel is one sinusoid of time, whatever its amplitude and phase in each recording.
bool follows_time(const StandProblem& problem, const Channel& channel, size_t index, const Evaluation& evaluation);

}  // namespace hrp::diagnosis::standing
