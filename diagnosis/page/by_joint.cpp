// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/by_joint.h"

#include <algorithm>
#include <set>

#include "diagnosis/page/headline.h"
#include "diagnosis/page/lead.h"

namespace hrp::diagnosis::html {
namespace {

constexpr size_t kMany = 8;    // findings at joints: a list of more is longer than what one looks at together
constexpr size_t kJoints = 3;  // fewer have nothing to compare

std::string get_joint(const json& finding) { return get_text(get_object(finding, "where"), "joint"); }

std::vector<const json*> list_of_joints(const json& report) {
  std::vector<const json*> out;
  for (const FindingGroup& group : list_shared(report)) {
    if (!group.is_shared() && !get_joint(*group.findings[0]).empty()) out.push_back(group.findings[0]);
  }
  return out;
}

bool is_enough(const std::vector<const json*>& findings) {
  std::set<std::string> joints;
  for (const json* f : findings) joints.insert(get_joint(*f));
  return findings.size() > kMany && joints.size() >= kJoints;
}

// "Coulomb friction [N m]" of an effect with one number, whose values can stand in one column. Empty for others.
std::string find_column(const json& finding) {
  const auto parameters = list_parameters(finding);
  if (parameters.size() != 1 || !get(parameters[0].second, "value").is_number()) return "";
  const std::string unit =
      get(finding, "in_log_unit") == json(true) ? "unit of the log" : typeset(get_text(parameters[0].second, "unit"));
  return describe_effect(get_text(finding, "effect")) + (unit.empty() || unit == "1" ? "" : " [" + unit + "]");
}

// Effects that two joints or more have, most frequent first.
std::vector<std::string> list_columns(const std::vector<const json*>& findings) {
  std::vector<std::pair<std::string, size_t>> counts;
  for (const json* f : findings) {
    const std::string column = find_column(*f);
    const auto same = std::find_if(counts.begin(), counts.end(), [&](const auto& c) { return c.first == column; });
    if (same == counts.end())
      counts.emplace_back(column, 1);
    else
      ++same->second;
  }
  std::stable_sort(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return b.second < a.second; });
  std::vector<std::string> out;
  for (const auto& [column, count] : counts) {
    if (!column.empty() && count > 1) out.push_back(column);
  }
  return out;
}

std::vector<std::string> list_joints(const json& report, const std::vector<const json*>& findings) {
  std::vector<std::string> out, found;
  for (const json* f : findings) found.push_back(get_joint(*f));
  for (const json& j : get_list(get_object(report, "checks"), "joints")) {
    if (std::count(found.begin(), found.end(), get_text(j, "joint")) > 0) out.push_back(get_text(j, "joint"));
  }
  for (const std::string& joint : found) {
    if (std::count(out.begin(), out.end(), joint) == 0) out.push_back(joint);
  }
  return out;
}

}  // namespace

JointTable make_joint_table(const json& report) {
  const std::vector<const json*> findings = list_of_joints(report);
  if (!is_enough(findings)) return {};
  const std::vector<std::string> columns = list_columns(findings);
  JointTable out;
  out.findings = findings;
  out.head = {"joint"};
  out.head.insert(out.head.end(), columns.begin(), columns.end());
  out.joints = list_joints(report, findings);
  out.cells.assign(out.joints.size(), std::vector<JointTable::Cell>(columns.size() + 1));
  bool others = false;
  for (const json* f : findings) {
    const size_t column =
        static_cast<size_t>(std::find(columns.begin(), columns.end(), find_column(*f)) - columns.begin());
    const size_t row =
        static_cast<size_t>(std::find(out.joints.begin(), out.joints.end(), get_joint(*f)) - out.joints.begin());
    const bool is_other = column == columns.size();
    others = others || is_other;
    out.cells[row][column].push_back(
        {is_other ? describe_effect(get_text(*f, "effect")) + ": " + describe_parameters(*f) : describe_number(*f),
         get_text(*f, "grade") == "ambiguous"});
  }
  if (others)
    out.head.push_back("other");
  else
    for (auto& row : out.cells) row.pop_back();
  return out;
}

}  // namespace hrp::diagnosis::html
