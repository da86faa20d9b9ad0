// SPDX-License-Identifier: BSD-3-Clause
// Steering a run from outside.
#pragma once

#include "common/bus/bus.h"
#include "hrp_idl/scheduling.h"

namespace hrp {

// `asked` when it is not negative, else the domain of the only run on this machine. Throws std::runtime_error with the
// list when there is none or more than one.
int choose_running_domain(int asked);

// Waits for a scheduler, sends the request, waits until the run shows that it was taken. Returns an exit code.
int send_request(Bus& bus, const msg::RunControl& control);

// Prints the run status, once or until the run ends. Returns an exit code.
int show_status(Bus& bus, bool follow);

}  // namespace hrp
