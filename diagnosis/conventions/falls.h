// SPDX-License-Identifier: BSD-3-Clause
// Recordings that end with a fall: many experiments do.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// The body hits the ground, or something hits it.
struct Crash {
  size_t recording = 0;
  double time = 0.0;   // [s]
  double times = 0.0;  // what the accelerometer reads there, over what it reads most of the time
};

// The first crash of each recording: an accelerometer and a force sensor of a foot read twenty times what they read
// most of the time, at once. No step does that to both, and a glitch of a log is in one of them.
std::vector<Crash> find_crashes(const Experiment& experiment);

// The recordings up to shortly before, with warnings. A recording of which too little would be left stays out, unless
// none were left.
Experiment cut_at_crashes(Experiment experiment);

}  // namespace hrp::diagnosis
