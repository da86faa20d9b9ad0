// SPDX-License-Identifier: BSD-3-Clause
// Round trip of a reliable sample between two processes, per vendor: bus_round_trip [size] [count]. Figures only, no
// pass or fail. Run it on one core (taskset -c 0) and on all: a wake-up across cores costs more than DDS does.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/bus/domain.h"
#include "common/bus/make_bus.h"

namespace {

using Clock = std::chrono::steady_clock;
const hrp::TopicSpec kAsk{"benchmark/ask", "hrp::msg::RobotState"};
const hrp::TopicSpec kAnswer{"benchmark/answer", "hrp::msg::RobotState"};

double find_microseconds(Clock::duration time) { return std::chrono::duration<double, std::micro>(time).count(); }

[[noreturn]] void answer_for_ever(const hrp::BusOptions& options) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto bus = hrp::make_bus(options);
  const auto writer = bus->make_writer(kAnswer);
  [[maybe_unused]] const auto reader =
      bus->make_reader(kAsk, hrp::Delivery::kReliable, [&](hrp::Bytes sample) { writer->write(sample); });
  while (true) bus->spin(std::chrono::seconds(1));
}

void measure(const hrp::BusOptions& options, size_t size, size_t count) {
  const Clock::time_point start = Clock::now();
  const auto bus = hrp::make_bus(options);
  std::vector<uint8_t> bytes(size, 0);
  bytes[1] = 1;  // CDR, little endian
  std::vector<double> times;
  times.reserve(count);
  Clock::time_point sent;
  std::atomic<bool> done{false};
  const auto writer = bus->make_writer(kAsk);
  const auto send = [&] {
    sent = Clock::now();
    writer->write({bytes.data(), bytes.size()});
  };
  const auto reader = bus->make_reader(kAnswer, hrp::Delivery::kReliable, [&](hrp::Bytes) {
    times.push_back(find_microseconds(Clock::now() - sent));
    if (times.size() < count) return send();
    done = true;
  });
  while (!writer->has_readers()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const double found = find_microseconds(Clock::now() - start) / 1000;
  // The way back may not be known yet: ask until there is a first answer.
  while (!done) {
    {
      std::lock_guard<std::recursive_mutex> lock(bus->mutex());
      if (times.empty()) send();
    }
    bus->spin(std::chrono::milliseconds(times.empty() ? 2 : 20));
  }
  std::sort(times.begin(), times.end());
  std::printf("%-8s %6zu bytes: median %6.1f us, p99 %7.1f us, found each other after %.0f ms\n",
              options.vendor.c_str(), size, times[count / 2], times[count * 99 / 100], found);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const size_t size = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 1024;
  const size_t count = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 20000;
  for (const std::string vendor : {"cyclone", "fast"}) {
    const auto claim = hrp::claim_free_domain("bus_round_trip");
    hrp::BusOptions options;
    options.vendor = vendor;
    options.domain = claim.domain();
    const pid_t child = fork();
    if (child == 0) answer_for_ever(options);
    const pid_t measuring = fork();  // each vendor in a process of its own, as in a run
    if (measuring == 0) {
      measure(options, (size + 3) & ~size_t{3}, count);
      std::_Exit(0);
    }
    waitpid(measuring, nullptr, 0);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
  }
}
