// SPDX-License-Identifier: BSD-3-Clause
// Faults of the run that is meant.
#pragma once

#include "common/bus/bus.h"
#include "common/node/join.h"
#include "servers/console/doctor/finding.h"

namespace hrp {

// Which run is meant; a problem when there is none, or several.
Finding judge_choice(const RunChoice& choice);
// What its scheduler says: it runs, or it is paused, waits for somebody, or is silent.
Finding check_phase(Bus& bus, const RunEntry& run);

}  // namespace hrp
