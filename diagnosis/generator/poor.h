// SPDX-License-Identifier: BSD-3-Clause
// First recordings that tell little, and further motions that somebody asks for of the same robot.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/generator/draft.h"

namespace hrp::cases {

// Replaces the draft's recordings by three of `seconds`: slow, small, and with one joint that stands still
// (of bipeds: sways, with the upper body still).
void impoverish(Draft* draft, double seconds, Prng random);

// Adds one recording for every file: a table of commands with the columns of a recording. Files whose name begins with
// `validate` are held out. `multisines`: as many recordings of as many seconds, but of the usual multisines; of bipeds
// squats with sways, and arms that move. A monitor stops a motion when a joint leaves its command: the recording ends
// there. Throws InsaneCase where hardly anything of a motion can be played.
void play(Draft* draft, const std::vector<std::string>& files, bool multisines, Prng random);

}  // namespace hrp::cases
