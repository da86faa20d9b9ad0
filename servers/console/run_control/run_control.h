// SPDX-License-Identifier: BSD-3-Clause
// Steering a run from outside.
#pragma once

#include "common/node/join.h"
#include "hrp_idl/scheduling.h"

namespace hrp {

// Waits for a scheduler, sends the request, waits until the run shows that it was taken. Returns an exit code.
int send_request(Bus& bus, const JoinedRun& run, msg::RunControl control);

// Prints the run status, once or until the run ends. Returns an exit code.
int show_status(Bus& bus, const JoinedRun& run, bool follow);

}  // namespace hrp
