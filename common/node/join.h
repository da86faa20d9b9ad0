// SPDX-License-Identifier: BSD-3-Clause
// How every program finds the run that it joins: controllers, servers started by hand, hrp-topic, hrp-run, hrp-viewer.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/bus/domain.h"
#include "common/bus/make_bus.h"

namespace CLI {
class App;
}

namespace hrp {

// Which run is meant, from the command line.
struct JoinOptions {
  int domain = -1;          // < 0: not said
  long run = -1;            // process of the launcher; < 0: not said
  std::string vendor;       // empty: the run's
  std::string secure;       // folder of the identity to join with
  bool only_looks = false;  // set by programs that write nothing
};

// Adds --run, --domain, --dds and --secure.
void add_join_options(CLI::App& app, JoinOptions* options);

struct JoinedRun {
  RunEntry entry;                     // domain and vendor are filled in always
  bool registered = false;            // else a domain named by hand, which no run of ours holds
  std::string vendor_of_run;          // entry.vendor is the one to join with
  std::shared_ptr<PlaceClaim> place;  // of a server that was not started by the launcher
  // This process is a child of the run's launcher, which speaks for it.
  bool is_launched_by_it() const;
};

// What is chosen among the runs that there are: one of them, or why none.
struct RunChoice {
  std::optional<JoinedRun> run;
  std::string problem;            // empty when `run` is there
  bool may_come = false;          // a run that fits may still start
  std::vector<RunEntry> several;  // when people have to choose
};

// The one run, or the one that is named. `role`: of a server, only runs that leave its place free; empty for those who
// look or steer.
RunChoice choose_run(const JoinOptions& options, const std::vector<RunEntry>& runs, const std::string& role = "");

struct Joiner {
  std::string program;  // "hrp-topic", for messages
  std::string role;     // of a server, else empty
  bool waits = false;   // for a run that may still start
};

// Finds the run. Asks on a terminal when there are several. Throws BusError, with what there is, when none fits and the
// joiner does not wait. Empty when a stop signal came while it waited.
std::optional<JoinedRun> find_run_to_join(const JoinOptions& options, const Joiner& joiner);

// Token of the run that holds the domain now; else the one that `run` was joined with. Who joins a domain before its
// run is registered learns the token later: ask when a request is signed.
std::string find_token(const JoinedRun& run);

// Why a secured run has one vendor.
inline const char* const kNoSecureMix =
    "a secured run has one DDS: Fast DDS 2.9 offers its Diffie-Hellman key as plain bytes, Cyclone DDS 0.10 reads it "
    "as ASN.1, so "
    "their handshake fails; give all programs the same --dds";

// Bus options with the run's domain and vendor and the identity of `join`, the rest as in `options`. Throws BusError
// when the run is secured and no identity is given, or the other way round.
BusOptions make_join_bus_options(const JoinedRun& run, const JoinOptions& join, BusOptions options = {});

// "domain 62 (cyclone), of models/scenarios/default.yaml (process 4711)"
std::string describe_place(const JoinedRun& run);

// Says once on standard error what a program waits for, where, and which runs there are, when it has waited for a
// while.
class WaitVoice {
 public:
  using Clock = std::chrono::steady_clock;
  WaitVoice(std::string program, JoinedRun run) : program_(std::move(program)), run_(std::move(run)) {}
  // `waits_for`: what is missing now, empty when nothing is.
  void update(const std::string& waits_for, Clock::time_point now);

 private:
  std::string program_;
  JoinedRun run_;
  std::string waits_for_;
  std::string said_;
  Clock::time_point since_{};
};

// True once the run has gone: its launcher holds the domain no more. Runs that no launcher of ours holds never go.
class RunWatch {
 public:
  explicit RunWatch(const JoinedRun& run) : run_(run) {}
  bool has_gone();

 private:
  JoinedRun run_;
  bool gone_ = false;
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace hrp
