// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace hrp {

// True once SIGINT, SIGTERM or SIGPIPE came, or the run that held the domain has ended. Handles the signals from now on.
std::function<bool()> make_run_watch(int domain);

}  // namespace hrp
