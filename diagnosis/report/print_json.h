// SPDX-License-Identifier: BSD-3-Clause
// JSON holds UTF-8 alone, but names of files and of columns may hold other bytes: these become U+FFFD.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hrp::diagnosis {

// `indent`: spaces of a level; -1: one line.
inline std::string print_json(const nlohmann::ordered_json& json, int indent = -1) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

// With keys in alphabetical order.
inline nlohmann::json copy_json(const nlohmann::ordered_json& json) { return nlohmann::json::parse(print_json(json)); }

}  // namespace hrp::diagnosis
