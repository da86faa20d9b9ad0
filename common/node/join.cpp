// SPDX-License-Identifier: BSD-3-Clause
#include "common/node/join.h"

#include <unistd.h>

#include <cstdio>
#include <iostream>
#include <thread>

#include <CLI/CLI.hpp>

#include "common/bus/bus.h"
#include "common/node/runner.h"

namespace hrp {
namespace {

// Whoever waits says so after this time; people are told two seconds.
constexpr auto kPatience = std::chrono::milliseconds(1000);
constexpr auto kLook = std::chrono::milliseconds(200);

RunChoice join_one(const RunEntry& entry, const JoinOptions& options) {
  JoinedRun run{entry, true, entry.vendor, nullptr};
  if (!options.vendor.empty()) run.entry.vendor = options.vendor;
  RunChoice choice;
  choice.run = std::move(run);
  return choice;
}

RunChoice refuse(const std::string& problem, bool may_come = false) {
  RunChoice choice;
  choice.problem = problem;
  choice.may_come = may_come;
  return choice;
}

RunChoice join_domain(const JoinOptions& options, const std::vector<RunEntry>& runs) {
  if (options.domain > kHighestDomain) {
    return refuse("--domain " + std::to_string(options.domain) + " is no DDS domain: expected 0 to " +
                  std::to_string(kHighestDomain));
  }
  for (const RunEntry& entry : runs) {
    if (entry.domain == options.domain) return join_one(entry, options);
  }
  RunEntry entry;
  entry.domain = options.domain;
  const char* token = std::getenv("HRP_RUN_TOKEN");  // of a run on another machine
  entry.token = token ? token : "";
  RunChoice choice = join_one(entry, options);
  choice.run->registered = false;
  return choice;
}

RunChoice join_process(const JoinOptions& options, const std::vector<RunEntry>& runs) {
  for (const RunEntry& entry : runs) {
    if (entry.process_id == options.run) return join_one(entry, options);
  }
  return refuse("--run " + std::to_string(options.run) + ": no run has this process id; runs on this machine:\n" +
                describe_entries(runs));
}

std::string describe_choices(const std::vector<RunEntry>& runs) {
  return "several runs go on, choose one with --run:\n" + describe_entries(runs);
}

// On a terminal. Empty when nothing usable was typed.
std::optional<RunEntry> ask(const std::vector<RunEntry>& runs) {
  std::fprintf(stderr, "Several runs go on:\n");
  for (size_t i = 0; i < runs.size(); ++i) std::fprintf(stderr, "  %zu   %s\n", i + 1, describe_entry(runs[i]).c_str());
  std::fprintf(stderr, "Which one? [1-%zu] ", runs.size());
  std::string line;
  if (!std::getline(std::cin, line)) return std::nullopt;
  const long number = std::atol(line.c_str());
  if (number < 1 || number > static_cast<long>(runs.size())) return std::nullopt;
  return runs[static_cast<size_t>(number) - 1];
}

// A server of a run that its launcher did not start holds its place there; false when another one does.
bool take_place(JoinedRun* run, const std::string& role) {
  if (role.empty() || !run->registered || run->is_launched_by_it()) return true;
  auto place = claim_place(run->entry.domain, role);
  if (!place) return false;
  run->place = std::make_shared<PlaceClaim>(std::move(*place));
  return true;
}

bool is_asked_on_terminal(const RunChoice& choice) {
  return !choice.several.empty() && isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1;
}

}  // namespace

void add_join_options(CLI::App& app, JoinOptions* options) {
  auto* run = app.add_option("--run", options->run,
                             "process id of the run to join (see hrp-run list); default: the only run of this machine")
                  ->check(CLI::PositiveNumber);
  app.add_option("--domain", options->domain, "DDS domain of the run to join")
      ->check(CLI::Range(0, kHighestDomain))
      ->excludes(run);
  app.add_option("--dds", options->vendor, "DDS of this program, which can talk to both; default: the run's")
      ->check(CLI::IsMember({"cyclone", "fast"}));
  app.add_option("--secure", options->secure, "folder of the identity to join with (scripts/secure.sh makes it)")
      ->check(CLI::ExistingDirectory);
}

bool JoinedRun::is_launched_by_it() const { return registered && entry.process_id == getppid(); }

RunChoice choose_run(const JoinOptions& options, const std::vector<RunEntry>& runs, const std::string& role) {
  if (options.domain >= 0) return join_domain(options, runs);
  if (options.run >= 0) return join_process(options, runs);
  std::vector<RunEntry> open;
  for (const RunEntry& entry : runs) {
    if (role.empty() || entry.has_free_place(role)) open.push_back(entry);
  }
  if (open.size() == 1) return join_one(open[0], options);
  if (open.size() > 1) {
    RunChoice choice = refuse(describe_choices(open));
    choice.several = std::move(open);
    return choice;
  }
  const std::string start = "start one with scripts/simulate.sh" + (role.empty() ? "" : " --without " + role);
  if (runs.empty()) return refuse("no run on this machine; " + start + ", or name a DDS domain with --domain", true);
  return refuse(
      "no run leaves the place of " + role + " free; " + start + "; runs on this machine:\n" + describe_entries(runs),
      true);
}

std::optional<JoinedRun> find_run_to_join(const JoinOptions& options, const Joiner& joiner) {
  std::string said;
  while (true) {
    RunChoice choice = choose_run(options, find_runs(), joiner.role);
    if (choice.run && !take_place(&*choice.run, joiner.role)) {
      choice = refuse(
          "the place of " + joiner.role + " is taken in " + describe_place(*choice.run) + " by another program", true);
    }
    if (choice.run) {
      if (!said.empty())
        std::fprintf(stderr, "%s: joins %s\n", joiner.program.c_str(), describe_place(*choice.run).c_str());
      return choice.run;
    }
    if (is_asked_on_terminal(choice)) {
      if (const auto chosen = ask(choice.several)) return join_one(*chosen, options).run;
      throw BusError("no run was chosen");
    }
    if (!joiner.waits || !choice.may_come) throw BusError(choice.problem);
    if (said != choice.problem)
      std::fprintf(stderr, "%s: waits for a run: %s\n", joiner.program.c_str(), choice.problem.c_str());
    said = choice.problem;
    std::this_thread::sleep_for(kLook);
    if (g_stop_signal) return std::nullopt;
  }
}

std::string find_token(const JoinedRun& run) {
  const bool is_elsewhere = !run.registered && !run.entry.token.empty();  // on another machine, with HRP_RUN_TOKEN
  if (is_elsewhere) return run.entry.token;
  for (const RunEntry& entry : find_runs()) {
    if (entry.domain == run.entry.domain && !entry.token.empty()) return entry.token;
  }
  return run.entry.token;
}

BusOptions make_join_bus_options(const JoinedRun& run, const JoinOptions& join, BusOptions options) {
  if (run.registered && run.entry.secured && join.secure.empty()) {
    throw BusError("the run on " + describe_place(run) +
                   " is secured: --secure DIR with an identity of its authority is needed");
  }
  if (run.registered && !run.entry.secured && !join.secure.empty()) {
    throw BusError("the run on " + describe_place(run) + " is not secured: --secure would meet nobody there");
  }
  if (run.registered && !join.secure.empty() && run.vendor_of_run != run.entry.vendor) throw BusError(kNoSecureMix);
  // On the machine of the launcher it is known where the others are.
  if (run.registered && options.network_interface.empty() && options.config_file.empty())
    options.network_interface = run.entry.network;
  options.secure = join.secure;
  options.only_looks = join.only_looks;
  options.domain = run.entry.domain;
  options.vendor = run.entry.vendor;
  return options;
}

std::string describe_place(const JoinedRun& run) {
  const std::string place = "domain " + std::to_string(run.entry.domain) + " (" + run.entry.vendor + ")";
  if (!run.registered) return place + ", which no run of this machine holds";
  return place + ", the run of " + run.entry.scenario + " (process " + std::to_string(run.entry.process_id) + ")";
}

void WaitVoice::update(const std::string& waits_for, Clock::time_point now) {
  if (waits_for != waits_for_) {
    waits_for_ = waits_for;
    since_ = now;
  }
  if (waits_for_.empty() || waits_for_ == said_ || now - since_ < kPatience) return;
  said_ = waits_for_;
  std::fprintf(stderr, "%s: waits for %s on %s; runs on this machine:\n%s\n", program_.c_str(), waits_for_.c_str(),
               describe_place(run_).c_str(), describe_entries(find_runs()).c_str());
}

bool RunWatch::has_gone() {
  const auto now = std::chrono::steady_clock::now();
  if (gone_ || !run_.registered || now < next_) return gone_;
  next_ = now + kLook;
  const auto holder = find_run_of_domain(run_.entry.domain);
  gone_ = !holder || holder->process_id != run_.entry.process_id;
  return gone_;
}

}  // namespace hrp
