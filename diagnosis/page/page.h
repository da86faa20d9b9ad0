// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hrp::diagnosis {

// The page for people, from the verdict (`report.json`, schema of docs/diagnosis.md) and its curves (`series.json`,
// docs/diagnosis_series.md; may be an empty object). One self-contained HTML file: no script, no style or font from
// elsewhere, every name escaped, the same input gives the same bytes. Missing or ill-typed keys leave a part out.
std::string make_html_report(const nlohmann::json& report, const nlohmann::json& series);

// Writes make_html_report() to `path`. Throws std::runtime_error naming the path when it cannot be written.
void write_html_report(const nlohmann::json& report, const nlohmann::json& series, const std::string& path);

}  // namespace hrp::diagnosis
