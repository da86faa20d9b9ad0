// SPDX-License-Identifier: BSD-3-Clause
// A server whose launcher is on another machine. Its standard input comes from there: first the token of the run, one
// line, so that no list of processes shows it; then a line a second for as long as the launcher lives.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "common/node/join.h"

namespace hrp {

// Silence after which the launcher, or the way to it, counts as gone.
constexpr auto kFarSilence = std::chrono::seconds(15);

// The run of --domain and --dds with the token of standard input. Runs of this machine are not looked at: one of them
// may have the same domain. Throws BusError when no token comes.
std::optional<JoinedRun> join_far_run(const JoinOptions& options);

// Asks this process to stop when standard input ends or is silent.
void end_with_far_launcher(const std::string& program);

}  // namespace hrp
