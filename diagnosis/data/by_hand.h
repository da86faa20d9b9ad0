// SPDX-License-Identifier: BSD-3-Clause
// What somebody did to a robot in one recording: loads that hung on it, hands and ropes that pulled at it.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Names of links that are fixed to others become those of the links that move with them, places with them. Throws
// InputError where the robot has no such link, or where its base moves and a load hangs on it: nothing predicts that.
void resolve_by_hand(const Experiment& experiment, Recording* recording);

// The recording in pieces, in each of which the same known forces act all the time. Stretches of unknown forces and, on a
// base that moves, of all forces are left out, and so are the moments in which a hand comes and goes.
std::vector<Recording> cut_at_pushes(const Experiment& experiment, const Recording& recording, std::vector<std::string>* warnings);

}  // namespace hrp::diagnosis
