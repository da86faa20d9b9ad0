// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/lead.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/base/join_words.h"
#include "common/effects/effect_info.h"
#include "diagnosis/page/fit_words.h"
#include "diagnosis/page/headline.h"

namespace hrp::diagnosis::html {
namespace {

// " ± 9", or nothing without a usable interval.
std::string describe_interval(const std::vector<double>& ci) {
  if (ci.size() != 2 || !std::isfinite(ci[0]) || !std::isfinite(ci[1])) return "";
  return " \u00b1 " + format_number(0.5 * (ci[1] - ci[0]), 2);
}

// "(0.1 ± 0.02, 0.3 ± 0.02, 0)": each axis with its interval, unless it is assumed.
std::string describe_vector(const json& p, bool assumed) {
  const json &values = get(p, "value"), &intervals = get_list(p, "ci95");
  std::string out;
  for (size_t i = 0; i < values.size(); ++i) {
    out += (out.empty() ? "(" : ", ") + format_value(values[i], 3);
    if (!assumed && i < intervals.size()) out += describe_interval(get_numbers({{"ci95", intervals[i]}}, "ci95"));
  }
  return out + ")";
}

std::string describe_value(const json& p) {
  return format_value(get(p, "value"), 3) + describe_interval(get_numbers(p, "ci95"));
}

// "stiffness 434 ± 9 N m/rad".
std::string describe_parameter(const std::string& name, const json& p) {
  std::string words = name;
  std::replace(words.begin(), words.end(), '_', ' ');
  const bool vector = get(p, "value").is_array(), assumed = get(p, "assumed") == json(true);
  std::string out = words + " " + (vector ? describe_vector(p, assumed) : describe_value(p));
  for (const json& axis : get_list(p, "unseen"))
    out += ", " + (axis.is_string() ? axis.get<std::string>() : "") + " unseen";
  const std::string unit = typeset(get_text(p, "unit"));
  return out + (unit.empty() || unit == "1" ? "" : " " + unit) + (assumed ? " (assumed)" : "");
}

}  // namespace

std::vector<std::pair<std::string, json>> list_parameters(const json& finding) {
  std::vector<std::pair<std::string, json>> out;
  for (const auto& [name, p] : get_object(finding, "parameters").items()) out.emplace_back(name, p);
  const EffectInfo* row = find_effect(get_text(finding, "effect"));
  if (!row) return out;
  const auto place = [&](const std::string& name) {
    const int at = find_parameter(*row, name);
    return at < 0 ? std::numeric_limits<int>::max() : at;
  };
  std::stable_sort(out.begin(), out.end(),
                   [&](const auto& a, const auto& b) { return place(a.first) < place(b.first); });
  return out;
}

std::string describe_number(const json& finding) {
  const auto parameters = list_parameters(finding);
  return parameters.empty()
             ? ""
             : describe_value(parameters[0].second) + (get(finding, "at_least") == json(true) ? " or more" : "");
}

std::string describe_parameters(const json& finding) {
  std::string out =
      join_words(list_parameters(finding), [](const auto& p) { return describe_parameter(p.first, p.second); });
  if (get(finding, "at_least") == json(true)) out += " (or more)";
  return out + (get(finding, "in_log_unit") == json(true) ? " (unit of the log)" : "");
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

std::string make_lead(const json& report) {
  std::string first, rest;
  for (const std::string& sentence : make_headline(report)) {
    if (first.empty())
      first = "<p class='lead'>" + escape(sentence) + "</p>";
    else
      rest += (rest.empty() ? "" : " ") + escape(sentence);
  }
  const std::string fit = make_noise_sentence(report);
  return first + (rest.empty() ? "" : "<p>" + rest + "</p>") + (fit.empty() ? "" : "<p>" + escape(fit) + "</p>");
}

}  // namespace hrp::diagnosis::html
