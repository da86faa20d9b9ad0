// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <iterator>

#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/version.h"
#include "common/node/join.h"
#include "common/node/runner.h"
#include "servers/console/doctor/ends.h"
#include "servers/console/doctor/machine.h"
#include "servers/console/doctor/run.h"

namespace {

constexpr auto kDiscovery = std::chrono::milliseconds(1500);  // both vendors announce ends within one

void print(const hrp::Findings& findings) {
  for (const hrp::Finding& each : findings) {
    std::printf("%-7s  %-13s  %s%s%s\n", each.problem ? "problem" : "ok", each.what.c_str(), each.says.c_str(),
                each.problem ? "   mend: " : "", each.mend.c_str());
  }
  std::fflush(stdout);
}

hrp::Findings look_into(const hrp::JoinedRun& run, const hrp::JoinOptions& join, hrp::BusOptions options) {
  hrp::Findings findings{hrp::check_places(run.entry.domain)};
  const auto add = [&](const hrp::Findings& more) { findings.insert(findings.end(), more.begin(), more.end()); };
  try {
    options = hrp::make_join_bus_options(run, join, options);
    const auto bus = hrp::make_bus(options);
    const auto ends = hrp::find_ends(options, kDiscovery);
    // Our own bus, another participant than the one that looks, has no ends yet.
    findings.push_back(hrp::judge_participants(ends, true));
    findings.push_back(hrp::check_phase(*bus, run.entry));
    for (const auto& judge : {hrp::judge_qos, hrp::judge_types, hrp::judge_names}) add(judge(ends));
  } catch (const std::exception& error) {
    add({hrp::make_problem("discovery", error.what(), "see the lines above")});
  }
  return findings;
}

// Prints each finding as soon as it is known.
hrp::Findings check_all(const hrp::JoinOptions& join, const hrp::BusOptions& options) {
  hrp::Findings all;
  const auto add = [&all](const hrp::Findings& more) {
    print(more);
    all.insert(all.end(), more.begin(), more.end());
  };
  add({hrp::check_run_folder()});
  const auto runs = hrp::find_runs();
  const hrp::RunChoice choice = hrp::choose_run(join, runs);
  const bool several_machines = !options.network_interface.empty() || !options.config_file.empty();
  add({hrp::judge_choice(choice), hrp::check_interface(options.network_interface),
       hrp::check_multicast(options.network_interface)});
  add(hrp::check_vendors());
  add({hrp::check_shared_memory()});
  add(hrp::check_environment(choice.run ? choice.run->entry.domain : -1));
  add({hrp::check_clock(runs, several_machines), hrp::check_files()});
  if (choice.run) add(look_into(*choice.run, join, options));
  return all;
}

constexpr const char* kChecks =
    "What is checked:\n"
    "  folder         the list of runs is in a folder that only you can enter\n"
    "  run            there is a run, and only one fits the options\n"
    "  interface      loopback, or the one of --network-interface, exists and is up\n"
    "  multicast      discovery packets come back (--network-interface only)\n"
    "  vendor         a message over loopback arrives with each DDS, and between them\n"
    "  shared memory  /dev/shm has no files of dead Fast DDS programs\n"
    "  environment    ROS_DOMAIN_ID, CYCLONEDDS_URI, FASTRTPS_DEFAULT_PROFILES_FILE fit the run\n"
    "  clock          it does not jump; with several machines, it is synchronized\n"
    "  files          a process may open enough files\n"
    "  domain         the domain of the run has room for one more participant\n"
    "  discovery      participants of the domain, and their vendors\n"
    "  phase          the run is not paused and does not wait for a server\n"
    "  qos            no reader asks for more than a writer offers, or misses the last sample\n"
    "  types, names   topics have the types and names of idl/\n"
    "Exit status: 0 no problem, 1 a problem, 2 wrong command line.\n"
    "Examples:\n"
    "  hrp-doctor                                    the only run of this machine\n"
    "  hrp-doctor --domain 7                         a run of servers started by hand\n"
    "  hrp-doctor --domain 7 --network-interface 192.168.1.10";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Finds out why a program sees no run or no data. Checks this machine, this session and one run. Prints one line\n"
      "per check: ok, or the problem and how to solve it. Does not change the run. Takes about five seconds.",
      "hrp-doctor");
  app.set_version_flag("--version", hrp::get_version_text("hrp-doctor"));
  app.footer(kChecks);
  hrp::JoinOptions join;
  join.only_looks = true;
  hrp::BusOptions options;
  hrp::add_join_options(app, &join);
  app.add_option("--network-interface", options.network_interface,
                 "IPv4 address of the interface that the run uses; default: loopback");
  app.add_option("--dds-config", options.config_file,
                 "file in the DDS vendor's own format, the same as for the servers")
      ->check(CLI::ExistingFile);
  if (const auto status = hrp::take_command_line(&app, argc, argv)) return *status;
  const hrp::Findings all = check_all(join, options);
  const auto problems = std::count_if(all.begin(), all.end(), [](const hrp::Finding& each) { return each.problem; });
  std::printf("%s\n", problems == 0 ? "no problem"
                                    : (std::to_string(problems) + (problems == 1 ? " problem" : " problems")).c_str());
  return problems == 0 ? hrp::kExitOk : hrp::kExitFailed;
}
