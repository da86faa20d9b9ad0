// SPDX-License-Identifier: BSD-3-Clause
// Sentences about how much nearer the model comes to the recordings. Empty where a report has no such figures.
#pragma once

#include <string>

#include "diagnosis/page/text.h"

namespace hrp::diagnosis::html {

// "Held-out errors fall: positions from 0.175 to 0.0151 rad, weight from 10.5 to 5.63 N."
std::string make_errors_sentence(const json& report);

// How much is explained, beside what can be predicted at all: only where a ceiling was measured.
std::string make_ceiling_sentence(const json& report);

// The fit on held-out recordings in units of the noise, or of the effort's spread.
std::string make_noise_sentence(const json& report);

}  // namespace hrp::diagnosis::html
