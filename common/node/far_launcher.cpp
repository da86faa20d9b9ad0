// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/far_launcher.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <thread>

#include "common/bus/bus.h"
#include "common/node/runner.h"

namespace hrp {
namespace {

// Bytes that came, up to the buffer's size; 0 or less when the launcher has gone or says nothing.
ssize_t read_some(char* buffer, size_t size) {
  const auto end = std::chrono::steady_clock::now() + kFarSilence;
  while (!g_stop_signal) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0) return 0;
    pollfd input{STDIN_FILENO, POLLIN, 0};
    const int ready = poll(&input, 1, static_cast<int>(left.count()));
    if (ready > 0) return read(STDIN_FILENO, buffer, size);
    if (ready < 0 && errno != EINTR) return -1;
  }
  return 0;
}

std::string read_line() {
  std::string line;
  for (char c = 0; read_some(&c, 1) == 1 && c != '\n';) line += c;
  return line;
}

}  // namespace

std::optional<JoinedRun> join_far_run(const JoinOptions& options) {
  JoinedRun run;
  run.entry.domain = options.domain;
  run.entry.vendor = run.vendor_of_run = options.vendor.empty() ? "cyclone" : options.vendor;
  run.entry.token = read_line();
  if (g_stop_signal) return std::nullopt;
  if (options.domain < 0 || run.entry.token.empty())
    throw BusError("--far-launcher needs --domain, and the token of the run on standard input");
  return run;
}

void end_with_far_launcher(const std::string& program) {
  std::thread([program] {
    char beats[64];
    while (read_some(beats, sizeof beats) > 0) {
    }
    if (!g_stop_signal) std::fprintf(stderr, "%s: the launcher has gone, or the way to it; ends\n", program.c_str());
    g_stop_signal = true;
  }).detach();
}

}  // namespace hrp
