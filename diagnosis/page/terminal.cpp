// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/terminal.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/join_words.h"
#include "diagnosis/page/by_joint.h"
#include "diagnosis/page/headline.h"
#include "diagnosis/page/lead.h"

namespace hrp::diagnosis {
namespace {

using namespace html;

using Row = std::vector<std::string>;

constexpr size_t kMostMissing = 4;  // lines about what was not recorded; the others are counted

// Characters that a terminal shows, not bytes.
size_t count_columns(const std::string& text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xc0) != 0x80; }));
}

std::string print_table(const std::vector<Row>& rows) {
  std::vector<size_t> width(rows[0].size(), 0);
  for (const Row& row : rows) {
    for (size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], count_columns(row[i]));
  }
  std::string out;
  for (const Row& row : rows) {
    std::string line;
    for (size_t i = 0; i < row.size(); ++i) line += row[i] + std::string(width[i] + 2 - count_columns(row[i]), ' ');
    line.erase(line.find_last_not_of(' ') + 1);
    out += "  " + line + "\n";
  }
  return out;
}

// Values of ambiguous findings stand in brackets.
std::string print_joints(const JointTable& table) {
  if (table.joints.empty()) return "";
  std::vector<Row> rows{table.head};
  for (size_t j = 0; j < table.joints.size(); ++j) {
    rows.push_back({table.joints[j]});
    for (const JointTable::Cell& cell : table.cells[j]) {
      rows.back().push_back(join_words(
          cell, [](const auto& entry) { return entry.ambiguous ? "(" + entry.text + ")" : entry.text; }, "; "));
    }
  }
  return "\n" + print_table(rows) + "  In brackets: ambiguous. The report lists what else each may be.\n";
}

std::string print_findings(const json& report) {
  const JointTable table = make_joint_table(report);
  std::vector<Row> rows{{"where", "effect", "value, 95 %", "grade", "takes away", "cannot be told from"}};
  for (const FindingGroup& group : list_shared(report)) {
    const json& f = *group.findings[0];
    if (std::count(table.findings.begin(), table.findings.end(), &f) > 0) continue;
    double share = 0.0;
    for (const json* g : group.findings)
      share += get_number(*g, "share", 0.0) / static_cast<double>(group.findings.size());
    rows.push_back({describe_places(group.findings), describe_effect(get_text(f, "effect")),
                    describe_parameters(f) + (group.is_shared() ? " at each" : ""), get_text(f, "grade"),
                    format_number(std::round(100.0 * share), 3) + " %", list_alternatives(f)});
  }
  return print_joints(table) + (rows.size() > 1 ? "\n" + print_table(rows) : "");
}

// By file and column, so that nobody takes it for judged.
std::string print_missing(const json& report) {
  std::string out;
  const json& list = get_list(report, "missing");
  for (size_t i = 0; i < std::min(kMostMissing, list.size()); ++i)
    out += "Not recorded: " + (list[i].is_string() ? list[i].get<std::string>() : "") + ".\n";
  if (list.size() > kMostMissing)
    out += "Not recorded: " + std::to_string(list.size() - kMostMissing) + " more, see report.json.\n";
  return out.empty() ? "" : "\n" + out;
}

}  // namespace

std::string make_summary_text(const json& report) {
  std::string out;
  for (const std::string& sentence : make_headline(report)) out += (out.empty() ? "" : " ") + sentence;
  return out;
}

std::string make_terminal_text(const json& report) {
  std::string out = get_text(report, "verdict") + "\n\n";
  for (const std::string& sentence : make_headline(report)) out += sentence + "\n";
  out += print_findings(report);
  for (const json& item : get_list(report, "unexplained")) {
    const std::string statement = typeset(get_text(item, "statement"));
    if (out.find(statement) == std::string::npos) out += "\n" + statement;
  }
  out += out.back() == '\n' ? "" : "\n";
  return out + print_missing(report);
}

}  // namespace hrp::diagnosis
