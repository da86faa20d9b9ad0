// SPDX-License-Identifier: BSD-3-Clause
// Left and right legs whose columns are exchanged in a recording: the body then rolls and turns, over feet that stand,
// the other way than its gyroscope says.
#pragma once

#include <string>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

// A suspicion, as a sentence; empty: none. Legs are told by names that differ in left and right alone.
std::string find_exchanged_legs(const Experiment& experiment);

}  // namespace hrp::diagnosis::floating
