// SPDX-License-Identifier: BSD-3-Clause
// Checks the samples of one recording: rate, regularity, repeated values.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// {"file", "role", "duration" [s], "samples", "rate" [Hz], "jitter" (share of a period), "gaps": [[from, to]],
//  "held": [{"signal", "rate"}]}: signals that change less often than samples come.
nlohmann::ordered_json make_sample_check(const Experiment& experiment, const Recording& recording);

}  // namespace hrp::diagnosis
