// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

// Moves a sensor's columns from a clock that is `late` [s]: reading(t + late) at t, by a line between samples. Columns
// with blanks have samples of their own: no line is drawn across a gap, and beyond the ends there are blanks.
void shift_columns(const std::string& sensor, double late, Recording* r);

}  // namespace hrp::diagnosis::floating
