// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hrp::diagnosis {

// The page for people, made from next.json: one self-contained file without scripts.
std::string make_next_page(const nlohmann::ordered_json& next, const std::string& robot);

}  // namespace hrp::diagnosis
