// SPDX-License-Identifier: BSD-3-Clause
// Readings that come late.
#pragma once

#include <string>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis::floating {

// Readings of all columns whose names begin so are `samples` behind those of the encoders.
void delay_columns(const std::string& begin, long samples, Experiment* e);

// Expects one finding alone: a delay of that sensor by so many samples at 250 Hz.
void expect_delay_alone(const Experiment& e, const char* sensor, long samples);

}  // namespace hrp::diagnosis::floating
