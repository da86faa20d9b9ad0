// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fuzz/time_limit.h"

#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>

extern "C" int __real_LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

constexpr int kTicks = 25;                  // in a limit, so a limit is exact to 4 %
constexpr std::chrono::seconds kLimit(25);  // the slowest input so far, a mesh, took 0.2 s
bool is_limited = false;
std::atomic<int> ticks{0};  // since the input began; a signal comes to any thread

// A signal's handler may call write() and abort(), but not printf().
void count_tick(int) {
  if (++ticks <= kTicks) return;
  constexpr char kSaid[] = "one input took more processor time than the limit\n";
  const ssize_t written = write(STDERR_FILENO, kSaid, sizeof kSaid - 1);
  static_cast<void>(written);
  std::abort();
}

}  // namespace

void hrp::test::limit_processor_time(std::chrono::microseconds limit) {
  is_limited = true;
  struct sigaction action = {};
  action.sa_handler = count_tick;
  action.sa_flags = SA_RESTART;
  sigaction(SIGPROF, &action, nullptr);
  const auto tick = limit / kTicks;
  const timeval part = {tick / std::chrono::seconds(1), (tick % std::chrono::seconds(1)).count()};
  const itimerval again_and_again = {part, part};
  setitimer(ITIMER_PROF, &again_and_again, nullptr);
}

extern "C" int __wrap_LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (!is_limited) hrp::test::limit_processor_time(kLimit);
  ticks = 0;
  return __real_LLVMFuzzerTestOneInput(data, size);
}
