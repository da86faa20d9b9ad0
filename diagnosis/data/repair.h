// SPDX-License-Identifier: BSD-3-Clause
// What logs of real machines do to readings, where there is no doubt how to undo it.
#pragma once

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Angles that jump by a whole turn between two samples go on instead. Returns how many jumps there were.
int unwrap_angle(std::vector<double>* angle);

// Single samples that jump and return at once become NaN: by ten times what 95 % of the signal's second differences stay
// below and by eight of its smallest steps, and both neighbours agree to a tenth of the jump. The jump is at least `of_spread` of the range of the signal's middle 90 %. A
// signal with more than one in a hundred is left as it is. Returns how many.
int drop_spikes(std::vector<double>* signal, double of_spread);

// Both, at all joints of the recording; each column that was changed is said in `warnings`. Commands that count other turns
// than their joint are shifted by whole turns.
void repair_recording(const Experiment& experiment, Recording* recording, std::vector<std::string>* warnings);

}  // namespace hrp::diagnosis
