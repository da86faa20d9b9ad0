// SPDX-License-Identifier: BSD-3-Clause
// The main of a dynamics server, ours or another engine's.
#pragma once

#include "common/node/dynamics_loop.h"
#include "common/node/runner.h"

namespace hrp {

// run_server() with a DynamicsLoop and its option --ros-rate.
int run_dynamics_server(int argc, char** argv, const ServerProgram& program, const EngineFactory& make_engine);

}  // namespace hrp
