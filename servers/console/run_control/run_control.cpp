// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/run_control/run_control.h"

#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "common/base/printable.h"
#include "common/messages/pubsub.h"
#include "common/messages/topics.h"
#include "common/node/run_token.h"
#include "common/node/runner.h"

namespace hrp {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kPatience = std::chrono::seconds(5);
const char kScheduler[] = "the scheduler";

void print(const msg::RunStatus& status) {
  std::printf("%s epoch %llu step %llu t = %.3f s, %.1f x real time%s%s%s%s\n", get_phase_text(status.phase()),
              static_cast<unsigned long long>(status.epoch()), static_cast<unsigned long long>(status.step()),
              status.time(), status.real_time_factor(), status.late().empty() ? "" : ", waits for ",
              make_printable_line(status.late()).c_str(), status.message().empty() ? "" : ": ",
              make_printable(status.message()).c_str());
  std::fflush(stdout);
}

// Spins until `done` or the end of patience; false then. Says after a while what it waits for.
template <typename Done>
bool wait_for(Bus& bus, Clock::duration patience, WaitVoice* voice, const std::string& what, Done done) {
  const auto end = Clock::now() + patience;
  while (Clock::now() < end && !g_stop_signal) {
    {
      std::lock_guard<std::recursive_mutex> lock(bus.mutex());
      if (done()) return true;
    }
    voice->update(what, Clock::now());
    bus.spin(std::chrono::milliseconds(5));
  }
  return false;
}

int say_no_scheduler(const JoinedRun& run) {
  if (!g_stop_signal) std::fprintf(stderr, "hrp-run: no scheduler answers on %s\n", describe_place(run).c_str());
  return kExitFailed;
}

bool has_taken(const msg::RunControl& control, const msg::RunStatus& before, const msg::RunStatus& now) {
  switch (control.request()) {
    case msg::REQUEST_RUN: return now.phase() == msg::RUN_RUNNING || is_over(now);
    case msg::REQUEST_PAUSE: return now.phase() == msg::RUN_PAUSED || is_over(now);
    case msg::REQUEST_STEP:
      return (now.phase() == msg::RUN_PAUSED && now.step() >= before.step() + control.steps()) || is_over(now);
    case msg::REQUEST_RESET: return now.epoch() > before.epoch();
    case msg::REQUEST_STOP: return is_over(now);
    case msg::REQUEST_PUSH: return now.answered() == control.nonce();
  }
  return true;
}

}  // namespace

int send_request(Bus& bus, const JoinedRun& run, msg::RunControl control) {
  WaitVoice voice("hrp-run", run);
  Publisher<msg::RunControl> publisher(bus, topics::kRunControl);
  msg::RunStatus status;
  std::string refused;
  bool heard = false;
  const auto reader =
      subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable, [&](const msg::RunStatus& m) {
        if (!may_believe(run.entry.token, status, m)) return;
        status = m;
        if (!m.refused().empty()) refused = m.refused();
        heard = true;
      });
  if (!wait_for(bus, kPatience, &voice, kScheduler, [&] { return heard && publisher.has_readers(); }))
    return say_no_scheduler(run);
  const msg::RunStatus before = status;
  refused.clear();
  control.nonce(make_nonce());
  sign(find_token(run), topics::kRunControl.type_name, &control);
  publisher.publish(control);
  const bool taken = wait_for(bus, kPatience, &voice, "the run to show the request",
                              [&] { return !refused.empty() || has_taken(control, before, status); });
  if (!refused.empty()) {
    std::fprintf(stderr, "hrp-run: refused: %s\n", make_printable(refused).c_str());
    return kExitBadInput;
  }
  print(status);
  if (!taken) std::fprintf(stderr, "hrp-run: sent, but the run does not show it yet\n");
  return taken ? kExitOk : kExitFailed;
}

int show_status(Bus& bus, const JoinedRun& run, bool follow) {
  WaitVoice voice("hrp-run", run);
  msg::RunStatus status;
  bool fresh = false, heard = false;
  const auto reader =
      subscribe<msg::RunStatus>(bus, topics::kRunStatus, Delivery::kReliable, [&](const msg::RunStatus& m) {
        if (!may_believe(run.entry.token, status, m)) return;
        status = m;
        fresh = heard = true;
      });
  while (!g_stop_signal) {
    if (!wait_for(bus, heard ? std::chrono::seconds(2) : kPatience, &voice, kScheduler, [&] { return fresh; })) break;
    std::lock_guard<std::recursive_mutex> lock(bus.mutex());
    fresh = false;
    print(status);
    if (!follow || is_over(status)) return kExitOk;
  }
  if (g_stop_signal) return kExitOk;
  if (!heard) return say_no_scheduler(run);
  std::fprintf(stderr, "hrp-run: the scheduler has fallen silent\n");
  return kExitFailed;
}

}  // namespace hrp
