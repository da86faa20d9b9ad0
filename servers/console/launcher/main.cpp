// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <new>

#include "common/base/diagnostics.h"
#include "common/node/runner.h"
#include "servers/console/launcher/options.h"
#include "servers/console/launcher/run_set.h"
#include "servers/console/launcher/summary.h"

int main(int argc, char** argv) {
  hrp::LaunchOptions options;
  int exit_code = 0;
  try {
    if (!hrp::parse_launch_options(argc, argv, &options, &exit_code)) return exit_code;
    hrp::handle_stop_signals();
    const hrp::Scenario scenario = hrp::load_scenario(options.scenario);
    const hrp::LogName name(hrp::choose_log_file(options, scenario));
    const std::string& log = name.path();
    hrp::check_robots(options, scenario);
    hrp::leave_out_absent_controllers(scenario, &options);
    const hrp::RunOutcome outcome = options.in_process ? hrp::run_in_this_process(options, scenario, log)
                                                       : hrp::run_as_processes(options, scenario, log);
    if (outcome.exit_code != hrp::kExitBadInput) hrp::print_summary(options, outcome, log);  // nothing has run
    hrp::wait_for_viewer(outcome);
    return outcome.exit_code;
  } catch (const hrp::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return hrp::kExitBadInput;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "hrp-simulate: memory ran out\n");
    return hrp::kExitFailed;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hrp-simulate: %s\n", error.what());
    return hrp::kExitFailed;
  }
}
