// SPDX-License-Identifier: BSD-3-Clause
// What a run says of itself to the programs of its user that would join it.
#pragma once

#include <string>
#include <vector>

namespace hrp {

struct RunEntry {
  int domain = -1;
  long process_id = 0;    // of the launcher
  long long started = 0;  // [s] since 1970
  std::string scenario;   // file, or what else the holder is
  std::string vendor = "cyclone";
  std::string log;        // empty: none
  std::string waits_for;  // role that everybody waits for, empty when none
  std::string token;      // without it requests and grants are ignored (common/node/run_token.h); empty: none
  std::string network;    // of a run on several machines: interface and peers (network_choice.h); empty: loopback
  bool secured = false;   // joined with an identity only (secure_folder.h)
  std::vector<std::string> free_places;  // roles that somebody else fills

  bool has_free_place(const std::string& role) const;
};

// Lines "key value", for a file.
std::string format_entry(const RunEntry& entry);
// Keys that are unknown or missing change nothing.
RunEntry parse_entry(const std::string& text);

// "--run 4711   models/scenarios/default.yaml   since 16:10:54   waits for controller   domain 62 (cyclone)   log
// run.mcap"
std::string describe_entry(const RunEntry& entry);
// One line each, indented; "none" when there is none.
std::string describe_entries(const std::vector<RunEntry>& entries);

}  // namespace hrp
