// SPDX-License-Identifier: BSD-3-Clause
// Findings about efforts that friction may be.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// A joint that rests may hold any torque up to its dry friction. So a zero or a gain of its drive, or of its log, may
// be that friction.
void doubt_efforts_at_rest(const Experiment& experiment, nlohmann::ordered_json* report);

// One scale above 1 of all efforts may be friction and rotors of all drives: both make efforts larger than what the
// links need. It is one scale only if it leaves next to nothing, or if losses were found beside it.
void doubt_common_scale(const Experiment& experiment, nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
