// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/topic_tool/run_watch.h"

#include <chrono>
#include <csignal>

#include "common/bus/domain.h"

namespace hrp {
namespace {

volatile std::sig_atomic_t g_signal = 0;

bool is_running(int domain) {
  for (const RunningDomain& running : find_running_domains()) {
    if (running.domain == domain) return true;
  }
  return false;
}

}  // namespace

std::function<bool()> make_run_watch(int domain) {
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) std::signal(signal, [](int number) { g_signal = number; });
  using Clock = std::chrono::steady_clock;
  // A domain that no launcher holds, as --domain may name, has no end that we could see.
  return [domain, held = is_running(domain), next = Clock::now()]() mutable {
    if (g_signal != 0) return true;
    if (!held || Clock::now() < next) return false;
    next = Clock::now() + std::chrono::milliseconds(200);
    return !is_running(domain);
  };
}

}  // namespace hrp
