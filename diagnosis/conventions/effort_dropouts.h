// SPDX-License-Identifier: BSD-3-Clause
// Finds stretches in which a log repeats one effort exactly although the motion takes another: lost frames, or a log
// that holds its last value. Such an effort is none.
//
// Efforts may also be constant by design: steps, pulses, drives that are released. Then the motion takes that effort.
// So a stretch counts only if the law of the joint's other samples,
//
//   effort = g tau + I a + d v + f sign(v) + b,   tau: nominal inverse dynamics,
//
// misses it by more than any detail of laws does (kAboveNoise), with odds beyond chance (kOdds), and by more than a
// detail of the effort (kDetail).
#pragma once

#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Samples from `begin` to before `end` of a recording, in which a joint's effort is `value` [N m or N].
struct Dropout {
  size_t recording = 0;
  int joint = 0;
  size_t begin = 0, end = 0;
  double value = 0.0;
};

// Of robots on a fixed base with recorded efforts.
std::vector<Dropout> find_dropouts(const Experiment& experiment);

// The experiment without these efforts (NaN), with a warning for each recording and joint.
Experiment leave_out_dropouts(Experiment experiment, const std::vector<Dropout>& dropouts);

}  // namespace hrp::diagnosis
