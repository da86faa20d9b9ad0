// SPDX-License-Identifier: BSD-3-Clause
// What discovery knows of the ends (readers and writers) of others, with the QoS that they offer or ask for. For those
// who look for a fault; the loop itself needs TopicSeen only.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "common/bus/make_bus.h"

namespace hrp {

struct EndSeen {
  std::string topic;
  std::string type_name;
  bool writer = false;           // else a reader
  bool reliable = false;         // offered by a writer, asked for by a reader
  bool transient_local = false;  // keeps (writer), or wants (reader), what was sent before the reader came
  std::string vendor;       // "cyclone", "fast", "secured" or "unknown", from the participant's GUID (RTPS 8.4.2.1)
  std::string participant;  // its GUID prefix in hexadecimal digits
};

// All ends of other participants in the domain after `patience`. It looks with Cyclone DDS whatever `options.vendor`
// is: discovery tells it of both. `options` are those of a bus that was made, so they are known to be good.
std::vector<EndSeen> find_ends(const BusOptions& options, std::chrono::milliseconds patience);

}  // namespace hrp
