// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/lead.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace hrp::diagnosis::html {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string make_fit_sentence(const json& report) {
  const json& fit = get(get(report, "fit"), "validate");
  const double before = get_number(fit, "before", kNone), after = get_number(fit, "after", kNone);
  if (!std::isfinite(before) || !std::isfinite(after)) return "";
  if (get_text(report, "verdict") == "no_mismatch") {
    return "On the held-out recordings the prediction error is " + format_number(after, 3) +
           " times the noise (1 is as good as it gets).";
  }
  return "On recordings never used for fitting the prediction error goes from " + format_number(before, 3) + " to " +
         format_number(after, 3) + " times the noise (1 is as good as it gets).";
}

// What a finding says in words: its statement without the place before and the numbers behind.
std::string make_clause(const std::string& statement) {
  const std::size_t colon = statement.find(": ");
  const std::size_t begin = colon != std::string::npos && colon < 60 ? colon + 2 : 0;
  const std::size_t end = std::min(statement.find(" (", begin), statement.find(". ", begin));
  std::string clause = statement.substr(begin, end == std::string::npos ? end : end - begin);
  while (!clause.empty() && clause.back() == '.') clause.pop_back();
  return clause;
}

// "stiffness 434 ± 9 N m/rad"; a value without a usable interval stands alone, a vector in parentheses.
std::string describe_parameter(const std::string& name, const json& p) {
  const std::vector<double> ci = get_numbers(p, "ci95");
  std::string words = name;
  std::replace(words.begin(), words.end(), '_', ' ');
  std::string out = words + " " + format_value(get(p, "value"), 4);
  if (ci.size() == 2 && std::isfinite(ci[0]) && std::isfinite(ci[1]))
    out += " \u00b1 " + format_number(0.5 * (ci[1] - ci[0]), 2);
  const std::string unit = get_text(p, "unit");
  return out + (unit.empty() || unit == "1" ? "" : " " + unit);
}

// Findings of one effect, with the same words, in one paragraph.
struct Group {
  std::string effect, clause, places, numbers;
  int count = 0;
};

std::vector<Group> make_groups(const json& report) {
  std::vector<Group> groups;
  for (const json& f : get_list(report, "findings")) {
    const std::string effect = get_text(f, "effect"), clause = make_clause(get_text(f, "statement"));
    const auto same = std::find_if(groups.begin(), groups.end(),
                                   [&](const Group& g) { return g.effect == effect && g.clause == clause; });
    Group& group = same == groups.end() ? groups.emplace_back(Group{effect, clause, "", "", 0}) : *same;
    const std::string place = describe_place(get(f, "where"));
    group.places += (group.count > 0 ? " and " : "") + place;
    group.numbers += (group.count > 0 ? "; " : "") + place + ": " + describe_parameters(f);
    ++group.count;
  }
  return groups;
}

std::string make_group_text(const Group& g) {
  return "<p class='lead'><b>" + escape(describe_effect(g.effect)) + "</b>" +
         (g.places.empty() ? "" : ", " + escape(g.places)) + (g.clause.empty() ? "" : ": " + escape(g.clause)) +
         ".</p><p class='small'>" + escape(g.numbers) + "</p>";
}

}  // namespace

std::string describe_parameters(const json& finding) {
  std::string out;
  for (const auto& [name, p] : get_object(finding, "parameters").items())
    out += (out.empty() ? "" : ", ") + describe_parameter(name, p);
  return out;
}

const VerdictWords& find_verdict_words(const std::string& verdict) {
  static const VerdictWords words[] = {
      {"no_mismatch", "Nothing is missing", "The model explains these recordings down to their noise."},
      {"explained", "Explained", "What the simulation left out was found; with it the recordings are explained."},
      {"mostly_explained", "Mostly explained",
       "Most of what can be predicted from these recordings is explained by what was found."},
      {"not_judged", "Not judged", "These recordings lack what a comparison needs."},
      {"partly_explained", "Partly explained", "Some of what the simulation left out was found; something remains."},
      {"unexplained", "Not explained", "The simulation leaves something out that none of the known effects explains."}};
  static const VerdictWords other{"", "No verdict", "The tool reached no verdict."};
  for (const VerdictWords& w : words) {
    if (verdict == w.verdict) return w;
  }
  return other;
}

std::string shorten_path(const std::string& path) {
  const std::size_t file = path.rfind('/');
  if (file == std::string::npos || file == 0) return path;
  const std::size_t folder = path.rfind('/', file - 1);
  return folder == std::string::npos ? path : path.substr(folder + 1);
}

std::string make_lead(const json& report, const json& series) {
  std::string out;
  const std::string summary = get_text(series, "summary");
  if (!summary.empty()) {
    out = "<p class='lead'>" + escape(summary) + "</p>";
  } else {
    for (const Group& group : make_groups(report)) out += make_group_text(group);
    for (const json& item : get_list(report, "unexplained"))
      out += "<p class='lead'>" + escape(get_text(item, "statement")) + "</p>";
  }
  if (out.empty()) out = "<p class='lead'>" + escape(find_verdict_words(get_text(report, "verdict")).sentence) + "</p>";
  const std::string fit = make_fit_sentence(report);
  return out + (fit.empty() ? "" : "<p>" + escape(fit) + "</p>");
}

}  // namespace hrp::diagnosis::html
