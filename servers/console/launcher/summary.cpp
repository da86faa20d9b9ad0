// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/summary.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>

#include "common/base/diagnostics.h"
#include "common/mcap/reader.h"
#include "common/messages/cdr.h"
#include "common/messages/topics.h"
#include "common/plot/svg_plot.h"
#include "hrp_idl/dynamics.h"

namespace hrp {
namespace {

namespace fs = std::filesystem;

struct LogEnd {
  bool any = false;
  uint64_t step = 0;
  double time = 0.0;  // [s]
  unsigned long long hash = 0;
  std::string damage;
};

LogEnd find_log_end(const std::string& log) {
  LogEnd end;
  mcap::Reader reader(log);
  msg::RobotState state;
  reader.read_messages(
      [&](const mcap::Message& message) {
        decode({message.data, message.size}, &state);
        end.any = true;
        end.step = state.header().step();
        end.time = state.header().time();
        end.hash = state.hash();
        return true;
      },
      {topics::kRobotState.name});
  end.damage = reader.damage();
  return end;
}

void print_plot(const std::string& log) {
  const std::string plot = fs::path(log).replace_extension(".contact_forces.svg").string();
  try {
    write_contact_force_plot(log, plot);
    std::printf("plot       %s\n", plot.c_str());
  } catch (const std::exception& error) {
    std::printf("plot       none: %s\n", error.what());
  }
}

std::string make_time_stamp() {
  const std::time_t now = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%d-%H%M%S", std::localtime(&now));
  return text;
}

}  // namespace

std::string choose_log_file(const LaunchOptions& options, const Scenario& scenario) {
  fs::path path = options.log.empty() ? scenario.logging.file : options.log;
  if (path.empty()) {
    path = fs::path("logs") / (fs::path(options.scenario).stem().string() + "-" + make_time_stamp() + ".mcap");
  }
  path = fs::absolute(path).lexically_normal();
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) {
    Diagnostic problem;
    problem.file = path.parent_path().string();
    problem.message = "the folder of the log cannot be made: " + error.message();
    throw InputError(problem);
  }
  return path.string();
}

void print_summary(const LaunchOptions& options, const RunOutcome& outcome, const std::string& log) {
  std::printf("simulated  %.3f s in %.2f s", outcome.simulated_time, outcome.wall_time);
  if (outcome.wall_time > 0.0) std::printf(" (%.1f x real time)", outcome.simulated_time / outcome.wall_time);
  std::printf("\n");
  const bool logged = std::find(options.without.begin(), options.without.end(), "logger") == options.without.end();
  if (!logged || !fs::exists(log)) return;
  try {
    const LogEnd end = find_log_end(log);
    std::printf("log        %s\n", log.c_str());
    if (end.any) {
      std::printf("           complete up to step %llu, t = %.3f s\n", static_cast<unsigned long long>(end.step), end.time);
      std::printf("state hash %016llx\n", end.hash);
    } else {
      std::printf("           holds no step\n");
    }
    if (end.any && options.plot) print_plot(log);
    if (!end.damage.empty()) std::printf("           the file was cut short and is readable up to there: %s\n", end.damage.c_str());
  } catch (const std::exception& error) {
    std::printf("           the log cannot be read: %s\n", error.what());
  }
}

}  // namespace hrp
