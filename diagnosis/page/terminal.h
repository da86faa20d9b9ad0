// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hrp::diagnosis {

// What an expert would say first (docs/report.md), one sentence after the other, for `summary` of report.json.
std::string make_summary_text(const nlohmann::json& report);

// The report for a terminal: verdict, headline, a table of the findings, what stays unexplained.
std::string make_terminal_text(const nlohmann::json& report);

}  // namespace hrp::diagnosis
