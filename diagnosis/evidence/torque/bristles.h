// SPDX-License-Identifier: BSD-3-Clause
// Dry friction whose surfaces bend before they slip is described by two terms: a level, and an element with memory that
// yields within a small angle. It is one cause and gets one name.
#pragma once

#include <vector>

#include "diagnosis/findings/finding.h"
#include "diagnosis/measurement/torque/torque.h"

namespace hrp::diagnosis {

// Where a level of dry friction and a hysteresis are found at a joint that travels much further than the hysteresis
// yields: the level takes both, and the hysteresis is its alternative.
void join_bristles(const TorqueData& data, std::vector<Finding>* findings);

}  // namespace hrp::diagnosis
