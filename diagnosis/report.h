// SPDX-License-Identifier: BSD-3-Clause
// From an outcome to report.json, series.json and the updated experiment.
#pragma once

#include <nlohmann/json.hpp>

#include "diagnosis/search.h"

namespace hrp::diagnosis {

using Json = nlohmann::ordered_json;

struct Reports {
  Json report, series;
};

Reports make_reports(const Problem& problem, const Outcome& outcome);

// DIR/report.json, DIR/series.json, DIR/report.html, DIR/updated/. Throws std::runtime_error naming what failed.
void write_reports(const Problem& problem, const Outcome& outcome, const std::string& folder, Reports reports);

// Parameters of one effect as the schema has them: vectors gathered under one name, nuisances left out.
Json make_parameters(const Effect& effect, const std::vector<double>& std, bool with_intervals);

}  // namespace hrp::diagnosis
