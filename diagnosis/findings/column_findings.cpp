// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/column_findings.h"

#include <algorithm>
#include <string>

#include "common/base/ends_with.h"

namespace hrp::diagnosis {
namespace {

bool is_of_columns(const Finding& f) {
  const std::string sensor = f.where.value("sensor", "");
  return sensor.rfind("/joint_states/", 0) == 0 && (ends_with(sensor, "/velocity") || ends_with(sensor, "/position"));
}

}  // namespace

void add_column_findings(const std::vector<Finding>& findings, nlohmann::ordered_json* report) {
  Evidence columns;
  std::copy_if(findings.begin(), findings.end(), std::back_inserter(columns.findings), is_of_columns);
  if (columns.findings.empty()) return;
  nlohmann::ordered_json& r = *report;
  const nlohmann::ordered_json made = make_report(columns)["findings"];
  for (const nlohmann::ordered_json& f : made) {
    const bool there = std::any_of(r["findings"].begin(), r["findings"].end(),
                                   [&](const nlohmann::ordered_json& other) { return other["where"] == f["where"]; });
    if (!there) r["findings"].push_back(f);
  }
  if (r["verdict"] == get_verdict_name(Verdict::kUnexplained))
    r["verdict"] = get_verdict_name(Verdict::kPartlyExplained);
}

}  // namespace hrp::diagnosis
