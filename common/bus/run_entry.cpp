// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/run_entry.h"

#include <cstdlib>
#include <ctime>
#include <functional>
#include <map>
#include <sstream>

#include "common/base/has.h"

namespace hrp {
namespace {

// A value is one line, and what is shown on a terminal holds no control characters.
std::string clean(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
  return text;
}

std::string format_time(long long seconds) {
  const std::time_t time = static_cast<std::time_t>(seconds);
  std::tm local{};
  char text[32] = "?";
  if (localtime_r(&time, &local)) std::strftime(text, sizeof text, "%H:%M:%S", &local);
  return text;
}

}  // namespace

bool RunEntry::has_free_place(const std::string& role) const { return has(free_places, role); }

std::string format_entry(const RunEntry& entry) {
  std::string text = "domain " + std::to_string(entry.domain) + "\nprocess " + std::to_string(entry.process_id) +
                     "\nstarted " + std::to_string(entry.started) + "\nscenario " + clean(entry.scenario) +
                     "\nvendor " + clean(entry.vendor) + "\nlog " + clean(entry.log) + "\nwaits_for " +
                     clean(entry.waits_for) + "\ntoken " + clean(entry.token) + "\nnetwork " + clean(entry.network) +
                     "\nsecured " + (entry.secured ? "1" : "0") + "\n";
  for (const std::string& role : entry.free_places) text += "free " + clean(role) + "\n";
  return text;
}

RunEntry parse_entry(const std::string& text) {
  RunEntry entry;
  const std::map<std::string, std::function<void(const std::string&)>> keys = {
      {"domain", [&](const std::string& v) { entry.domain = std::atoi(v.c_str()); }},
      {"process", [&](const std::string& v) { entry.process_id = std::atol(v.c_str()); }},
      {"started", [&](const std::string& v) { entry.started = std::atoll(v.c_str()); }},
      {"scenario", [&](const std::string& v) { entry.scenario = v; }},
      {"vendor", [&](const std::string& v) { entry.vendor = v; }},
      {"log", [&](const std::string& v) { entry.log = v; }},
      {"waits_for", [&](const std::string& v) { entry.waits_for = v; }},
      {"token", [&](const std::string& v) { entry.token = v; }},
      {"network", [&](const std::string& v) { entry.network = v; }},
      {"secured", [&](const std::string& v) { entry.secured = v == "1"; }},
      {"free", [&](const std::string& v) { entry.free_places.push_back(v); }},
  };
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const size_t blank = line.find(' ');
    const auto key = keys.find(line.substr(0, blank));
    if (key != keys.end() && blank != std::string::npos) key->second(line.substr(blank + 1));
  }
  return entry;
}

std::string describe_entry(const RunEntry& entry) {
  std::string text = "--run " + std::to_string(entry.process_id) + "   " + entry.scenario + "   since " +
                     format_time(entry.started) + "   domain " + std::to_string(entry.domain) + " (" + entry.vendor +
                     ")";
  if (entry.secured) text += "   secured";
  if (!entry.waits_for.empty()) text += "   waits for " + entry.waits_for;
  if (!entry.log.empty()) text += "   log " + entry.log;
  return text;
}

std::string describe_entries(const std::vector<RunEntry>& entries) {
  if (entries.empty()) return "  none";
  std::string text;
  for (const RunEntry& entry : entries) text += (text.empty() ? "  " : "\n  ") + describe_entry(entry);
  return text;
}

}  // namespace hrp
