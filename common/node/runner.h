// SPDX-License-Identifier: BSD-3-Clause
// Runs nodes: one in a process of its own, or all of them in one thread.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/memory/memory_bus.h"
#include "common/node/node.h"

namespace CLI {
class App;
}

namespace hrp {

// Exit codes of every program of the tree.
enum ExitCode { kExitOk = 0, kExitFailed = 1, kExitBadInput = 2, kExitInterrupted = 130 };

// Set by SIGINT, SIGTERM and SIGHUP (unless it was ignored from the start) once handle_stop_signals() was called.
extern std::atomic<bool> g_stop_signal;
void handle_stop_signals();

// Ends this process (SIGTERM) when its parent ends, however that ends. False when the parent is gone already.
[[nodiscard]] bool end_with_parent(long parent_process_id);

// One node on a DDS bus until it has ended or a signal comes. Returns an exit code; says failures on stderr. `on_look`
// runs at every idle time, without the bus's mutex, with what the node waits for.
int run_process(Node& node, Bus& bus, const std::string& program,
                const std::function<void(const std::string& waits_for)>& on_look = nullptr);

// All nodes on one memory bus, in this thread: deliveries in the order of writes, so a run repeats to the bit.
// `on_tick` runs every 100 ms or so. A stop signal goes to `stop_first`, which ends the others by the protocol.
void run_in_process(const std::vector<Node*>& nodes, MemoryBus& bus, Node* stop_first,
                    const std::function<void()>& on_tick = nullptr);

struct ServerProgram {
  std::string role;         // "dynamics"
  std::string program;      // "hrp-dynamics"
  std::string description;  // for --help
};

using NodeMaker = std::function<std::unique_ptr<Node>(const NodeContext& context)>;
using OptionAdder = std::function<void(CLI::App& app)>;

// The main of every server: common options (--domain, --dds, --role, ...), bus, node, loop, exit code.
int run_server(int argc, char** argv, const ServerProgram& program, const NodeMaker& make_node,
               const OptionAdder& add_options = nullptr);

}  // namespace hrp
