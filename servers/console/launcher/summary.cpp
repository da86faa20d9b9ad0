// SPDX-License-Identifier: BSD-3-Clause
#include "servers/console/launcher/summary.h"

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <numeric>
#include <set>

#include "common/base/bit_hash.h"
#include "common/base/diagnostics.h"
#include "common/base/has.h"
#include "common/base/printable.h"
#include "common/mcap/claimed_file.h"
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
  std::vector<std::string> falls;  // in words, the first one of each robot
  std::string damage;
};

std::vector<std::string> find_falls(mcap::Reader* log) {
  std::set<std::string> events;
  for (const auto& [id, channel] : log->channels()) {
    if (topics::find_known_topic(channel.topic) == &topics::kEvents) events.insert(channel.topic);
  }
  std::vector<std::string> falls;
  if (events.empty()) return falls;
  std::set<uint16_t> fallen;
  msg::RobotEvent event;
  log->read_messages(
      [&](const mcap::Message& message) {
        decode({message.data, message.size}, &event);
        if (event.kind() != msg::EVENT_FALL || !fallen.insert(message.channel_id).second) return true;
        char time[40];
        std::snprintf(time, sizeof time, "t = %.3f s: ", event.header().time());
        falls.push_back(make_printable_line(time + event.text()));
        return fallen.size() < events.size();
      },
      events);
  return falls;
}

LogEnd find_log_end(const std::string& log) {
  LogEnd end;
  mcap::Reader reader(log);
  end.falls = find_falls(&reader);
  msg::RobotState state;
  const mcap::Channel* channel = reader.find_channel(topics::kRobotState.name);
  const auto note = [&](const mcap::Message& message) {
    if (channel == nullptr || message.channel_id != channel->id) return true;
    decode({message.data, message.size}, &state);
    end.any = true;
    end.step = state.header().step();
    end.time = state.header().time();
    end.hash = state.hash();
    return true;
  };
  if (reader.indexed()) {
    // A log that was closed ends with its last state: to unpack all of it took a seventh of the time of a short run.
    for (size_t chunk = reader.chunk_count(); chunk-- > 0 && !end.any;) reader.read_chunk(chunk, note);
  } else {
    reader.read_messages(note, {topics::kRobotState.name});
  }
  end.damage = make_printable_line(reader.damage());
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

[[noreturn]] void refuse_log(const std::string& reason) { refuse_input({""}, "the log cannot be written: " + reason); }

// A name that nobody has: "run.mcap", else "run-2.mcap", "run-3.mcap", ... The file, without a step, keeps it for us.
fs::path reserve_name(const fs::path& wanted) {
  fs::path name = wanted;
  for (int number = 2;; ++number) {
    try {
      if (mcap::reserve_file(name.string())) return name;
    } catch (const mcap::McapError& error) {
      refuse_log(error.what());
    }
    name = wanted;
    name.replace_filename(wanted.stem().string() + "-" + std::to_string(number) + wanted.extension().string());
  }
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) refuse_log(folder.string() + " cannot be made: " + error.message());
}

// Before anything is started: a log that would be overwritten, a file that cannot be written.
void check_log_file(const fs::path& path, bool force) {
  try {
    mcap::ClaimedFile(path, force ? mcap::Existing::kReplace : mcap::Existing::kRefuse);
  } catch (const mcap::McapError& error) {
    refuse_log(error.what());
  }
}

void print_times(const RunOutcome& outcome) {
  const double simulated = std::accumulate(outcome.parts.begin(), outcome.parts.end(), 0.0);
  std::printf("simulated  %.3f s in %.2f s", simulated, outcome.wall_time);
  if (outcome.wall_time > 0.0) std::printf(" (%.1f x real time)", simulated / outcome.wall_time);
  if (outcome.parts.size() > 1) std::printf(", in %zu parts", outcome.parts.size());
  std::printf("\n");
}

// True when there is something in it to be played back.
bool print_log(const std::string& log, bool plot) {
  std::printf("log        %s\n", log.c_str());
  try {
    const LogEnd end = find_log_end(log);
    if (end.any) {
      std::printf("           complete up to step %llu, t = %.3f s\n", static_cast<unsigned long long>(end.step),
                  end.time);
      for (const std::string& fall : end.falls) std::printf("fall       %s\n", fall.c_str());
      std::printf("state hash %s\n", format_hash(end.hash).c_str());
    } else {
      std::printf("           holds no step\n");
    }
    if (end.any && plot) print_plot(log);
    if (!end.damage.empty())
      std::printf("           the file was cut short and is readable up to there: %s\n", end.damage.c_str());
    return end.any;
  } catch (const std::exception& error) {
    std::printf("           the log cannot be read: %s\n", error.what());
    return false;
  }
}

// The command that plays the logs back: the script beside the one that this run was started by, else the viewer itself.
void print_playback(const std::vector<std::string>& logs) {
  const char* script = std::getenv("HRP_VIEW_COMMAND");
  std::printf("play back  %s", script != nullptr ? script : "hrp-viewer");
  for (const std::string& file : logs) std::printf(" %s", file.c_str());
  std::printf("\n");
}

}  // namespace

bool is_logged(const LaunchOptions& options) { return !has(options.without, "logger"); }

LogName::~LogName() {
  try {
    std::error_code ignored;
    if (!fs::is_regular_file(path_, ignored) || mcap::holds_something(path_)) return;
    mcap::ClaimedFile(path_, mcap::Existing::kRefuse);  // takes empty files with it
  } catch (const std::exception&) {
    // A logger that does not end still has it, or memory ran out.
  }
}

std::string choose_log_file(const LaunchOptions& options, const Scenario& scenario) {
  fs::path path = options.log.empty() ? scenario.logging.file : options.log;
  if (path.empty()) {
    path = fs::path("logs") / (fs::path(options.scenario).stem().string() + "-" + make_time_stamp() + ".mcap");
  }
  path = fs::absolute(path).lexically_normal();
  if (!is_logged(options)) return path.string();
  make_folder(path.parent_path());
  if (options.log.empty() && !options.force) return reserve_name(path).string();
  check_log_file(path, options.force);
  return path.string();
}

void print_summary(const LaunchOptions& options, const RunOutcome& outcome, const std::string& log) {
  print_times(outcome);
  if (!is_logged(options)) return;
  std::vector<std::string> logs = outcome.logs;
  // A logger that was killed may have had no time to say where it writes; what is new can only be its.
  if (logs.empty() && !options.force && mcap::holds_something(log)) logs.push_back(log);
  if (logs.empty()) std::printf("log        none: the run ended before its first step\n");
  std::vector<std::string> played;
  for (const std::string& file : logs) {
    if (print_log(file, options.plot)) played.push_back(file);
  }
  if (!played.empty()) print_playback(played);
}

}  // namespace hrp
