// SPDX-License-Identifier: BSD-3-Clause
// External forces by hand in one recording: loads that hung on the robot, and hands or ropes that pulled at it.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Replaces links that are fixed to others by the links that move with them, and converts positions to their frames.
// Throws InputError if the robot has no such link, or if a load hangs on a robot with a moving base, which is not
// modelled.
void resolve_by_hand(const Experiment& experiment, Recording* recording);

// Divides the recording into pieces with constant known forces. Leaves out stretches with unknown forces (on a moving
// base: with any force), and the moments at which a force starts or ends.
std::vector<Recording> cut_at_pushes(const Experiment& experiment, const Recording& recording,
                                     std::vector<std::string>* warnings);

}  // namespace hrp::diagnosis
