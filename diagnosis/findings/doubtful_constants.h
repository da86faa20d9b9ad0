// SPDX-License-Identifier: BSD-3-Clause
// Constant torques in the joints of a robot on its feet, where the place of a mass is in question.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/data/recording.h"

namespace hrp::diagnosis {

// Drives of legs bear what stands on them, and force sensors under the feet tell with which moments. As long as an ambiguous
// finding may be a mass or its place, or is only told apart from one by a sensor's zero, constant torques may be its weight:
// they become `ambiguous`, with those masses among their alternatives. Does nothing on a fixed base.
void doubt_constants_of_masses(const Experiment& experiment, nlohmann::ordered_json* report);

}  // namespace hrp::diagnosis
