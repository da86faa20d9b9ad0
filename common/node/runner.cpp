// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/runner.h"

#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "common/base/check.h"
#include "common/base/printable.h"

namespace hrp {

std::atomic<bool> g_stop_signal{false};

namespace {

using Clock = std::chrono::steady_clock;

// After a stop was asked for, a node that does not end by itself is left behind after this time.
constexpr auto kStopPatience = std::chrono::seconds(5);

void note_stop_signal(int) { g_stop_signal = true; }

bool is_running(const Node& node) { return node.outcome() == NodeOutcome::kRunning; }

bool g_has_parent = false;

int find_exit_code(const Node& node, const std::string& program) {
  if (node.outcome() != NodeOutcome::kFailed) return kExitOk;
  if (g_has_parent && node.has_told_failure()) return kExitFailed;
  // A refused model goes through the bus to the scheduler and the launcher; the terminal they share is told once.
  if (g_has_parent && node.failure().substr(0, node.failure().find('\n')).find("model refused") != std::string::npos)
    return kExitFailed;
  std::fprintf(stderr, "%s: %s\n", program.c_str(), make_printable(node.failure()).c_str());
  return kExitFailed;
}

}  // namespace

void handle_stop_signals() {
  struct sigaction action = {};
  action.sa_handler = note_stop_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // A terminal that is closed ends the run as Ctrl-C does, with a closed log; who started it with nohup wants it to go
  // on.
  struct sigaction before = {};
  if (sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

bool end_with_parent(long parent_process_id) {
  if (parent_process_id <= 0) return true;
  g_has_parent = true;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  return getppid() == parent_process_id;
}

namespace {

int run_until_end(Node& node, Bus& bus, const std::string& program,
                  const std::function<void(const std::string& waits_for)>& on_look) {
  Clock::time_point next_idle = Clock::now(), give_up{};
  bool stopping = false;
  std::string waits_for;
  while (true) {
    node.make_endpoints();
    if (on_look && !stopping) on_look(waits_for);
    {
      std::lock_guard<std::recursive_mutex> lock(bus.mutex());
      const auto now = Clock::now();
      if (g_stop_signal && !stopping) {
        stopping = true;
        give_up = now + kStopPatience;
        node.request_stop();
      }
      node.on_idle(now);
      if (!is_running(node)) return find_exit_code(node, program);
      if (stopping && now > give_up) {
        std::fprintf(stderr, "%s: did not end when asked to\n", program.c_str());
        return kExitFailed;
      }
      next_idle = now + node.idle_period();
      waits_for = node.find_missing();
    }
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(next_idle - Clock::now());
    if (left.count() > 0) bus.spin(left);
  }
}

}  // namespace

int run_process(Node& node, Bus& bus, const std::string& program,
                const std::function<void(const std::string& waits_for)>& on_look) {
  const int exit_code = run_until_end(node, bus, program, on_look);
  node.drop_endpoints();
  return exit_code;
}

void run_in_process(const std::vector<Node*>& nodes, MemoryBus& bus, Node* stop_first,
                    const std::function<void()>& on_tick) {
  auto next_idle = Clock::now(), next_tick = Clock::now();
  const auto any_running = [&nodes] {
    return std::any_of(nodes.begin(), nodes.end(), [](const Node* node) { return is_running(*node); });
  };
  bool stopping = false;
  for (Node* node : nodes) node->make_endpoints();
  while (any_running()) {
    if (g_stop_signal && !stopping) {
      stopping = true;
      stop_first->request_stop();
    }
    const bool busy = bus.dispatch_all(256) > 0;
    const auto now = Clock::now();
    if (now >= next_idle) {
      next_idle = now + std::chrono::milliseconds(2);
      for (Node* node : nodes) {
        if (!is_running(*node)) continue;
        node->make_endpoints();
        node->on_idle(now);
      }
    } else if (!busy) {
      bus.spin(std::chrono::milliseconds(1));
    }
    if (on_tick && now >= next_tick) {
      next_tick = now + std::chrono::milliseconds(100);
      on_tick();
    }
  }
  bus.dispatch_all(1 << 16);
  if (on_tick) on_tick();
}

}  // namespace hrp
