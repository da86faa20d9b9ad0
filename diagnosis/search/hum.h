// SPDX-License-Identifier: BSD-3-Clause
// Servos that oscillate faster than the log samples, and what the log shows of it at other joints.
#pragma once

#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Joints whose servo oscillates at its effort limit faster than the log's sampling rate: most samples are at the limit,
// and the velocity is not the rate of the position. Simulated recordings of stiff servos on light links show this.
// `shaken`: joints whose velocity is far from the position's rate, as the oscillation shakes them.
struct Hum {
  std::vector<int> humming, shaken;
};
Hum find_hum(const Experiment& experiment);

// The experiment with readings of the other joints as their means over the oscillation. A log that meets it always in
// the same phase reads the velocity v + dv, dv constant [rad/s]. A servo that damps with kd then logs -kd dv too much
// [N m]. dv is the mean of the velocity less that of the position's rate, by recording. Humming and shaken joints stay
// as they are, and so do joints without velocity or effort.
Experiment take_out_hum(Experiment experiment, const Hum& hum);

}  // namespace hrp::diagnosis
