// SPDX-License-Identifier: BSD-3-Clause
// What the test and its peer process talk about.
#pragma once

#include <string>

#include "common/bus/bus.h"

namespace hrp::conformance {

constexpr int kDepth = 512;
inline const TopicSpec kAsk{"conformance/ask", "hrp::msg::RobotState", Retention::kStream, kDepth};
inline const TopicSpec kAnswer{"conformance/answer", "hrp::msg::RobotState", Retention::kStream, kDepth};
inline const TopicSpec kLatestAsk{"conformance/latest_ask", "hrp::msg::StepGrant", Retention::kLatest, 1};
inline const TopicSpec kLatestAnswer{"conformance/latest_answer", "hrp::msg::StepGrant", Retention::kLatest, 1};

// Cyclone DDS refuses colons in names of topics.
inline std::string find_plain(std::string type) {
  for (char& c : type) c = c == ':' ? '_' : c;
  return type;
}

inline TopicSpec find_typed_ask(const std::string& type) { return {"conformance/ask/" + find_plain(type), type}; }
inline TopicSpec find_typed_answer(const std::string& type) { return {"conformance/answer/" + find_plain(type), type}; }

}  // namespace hrp::conformance
