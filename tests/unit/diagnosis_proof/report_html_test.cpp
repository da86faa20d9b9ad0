// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <sstream>
#include <vector>

#include "diagnosis/page/checks.h"

namespace hrp::diagnosis {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json make_report(const std::string& verdict) {
  json report = json::parse(R"({"schema": 1, "mismatch": [{"signal": "/joint_states/elbow/effort",
    "recording": "a.csv", "score": 31.2, "intervals": [[1.2, 1.38]], "regime": "velocity reversal"}],
    "findings": [{"effect": "coulomb_friction", "where": {"joint": "elbow"}, "probability": 0.99,
      "parameters": {"level": {"value": 3.02, "std": 0.03, "ci95": [2.96, 3.08], "unit": "N m"},
                     "com": {"value": [1, 2, 3], "ci95": [[0, 2], [1, 3], [2, 4]], "unit": "m"}},
      "statement": "Dry friction.", "alternatives": [{"effect": "stribeck_friction"}]}],
    "unexplained": [{"where": {"joint": "wrist"}, "depends_on": ["position"], "statement": "Something acts."}],
    "not_identifiable": [{"effect": "payload", "why": "never moved", "motion_that_would_tell": "lift it"}],
    "fit": {"train": {"before": 14.1, "after": 1.03}, "validate": {"before": 13.8, "after": 1.05},
            "per_signal": {"/joint_states/elbow/effort": {"before": 0.41, "after": 0.02}}}})");
  report["verdict"] = verdict;
  return report;
}

json make_series() {
  return json::parse(R"({"schema": 1, "experiment": "lab", "robot": "arm",
    "signals": [{"name": "/joint_states/elbow/effort", "unit": "N m", "noise": 0.02}],
    "recordings": [{"file": "v.csv", "role": "validate",
      "map": {"start": 0, "step": 0.5, "rows": [{"signal": 0, "before": [1, 50, null], "after": [1, 1, 1]}]},
      "marks": [{"kind": "reversal", "where": "elbow", "from": 0.5, "to": 0.7}],
      "traces": [{"signal": 0, "time": [0, 1, 2], "recorded": [0, 1, null], "before": [0, 0, 0], "after": [0, 1, 0]}]}],
    "rivals": [{"effect": "viscous_friction", "where": {"joint": "elbow"}, "probability": 1e-9,
                "validate_score": 6.3, "chosen": false, "why": "leaves a step at every reversal"}],
    "clouds": [{"title": "t", "x": "v", "y": "e", "before": [[0, 1], [1, 2]], "after": [], "curve": [[0, 1], [1, 2]]}],
    "updated": {"scenario": "updated/experiment.yaml", "text": "a: b", "command": "run it"}, "notes": ["a note"]})");
}

// Checks that every tag that needs an end has one, in the right order. Empty: well formed.
std::string find_fault(const std::string& page) {
  static const std::set<std::string> empty_tags{"meta", "!DOCTYPE"};
  std::vector<std::string> open;
  for (std::size_t at = 0; (at = page.find('<', at)) != std::string::npos; ++at) {
    const std::size_t end = page.find('>', at);
    if (end == std::string::npos) return "unclosed <";
    const bool closing = page[at + 1] == '/';
    const std::size_t name_at = at + 1 + closing, name_end = page.find_first_of(" >/", name_at);
    const std::string name = page.substr(name_at, name_end - name_at);
    if (closing) {
      if (open.empty() || open.back() != name)
        return "</" + name + "> closes " + (open.empty() ? "nothing" : open.back());
      open.pop_back();
    } else if (!empty_tags.count(name) && page[end - 1] != '/') {
      open.push_back(name);
    }
    at = end - 1;
  }
  return open.empty() ? "" : open.back() + " stays open";
}

TEST(HtmlReport, IsWellFormedForEveryVerdictWithAndWithoutCurves) {
  for (const char* verdict : {"no_mismatch", "explained", "partly_explained", "unexplained", "", "something new"}) {
    for (const json& series : {make_series(), json::object(), json()}) {
      EXPECT_EQ(find_fault(make_html_report(make_report(verdict), series)), "") << verdict;
    }
    EXPECT_EQ(find_fault(make_html_report({{"verdict", verdict}}, json())), "") << verdict;
  }
}

TEST(HtmlReport, SaysWhatWasFoundWhyRivalsLostAndWhatTheDataCannotTell) {
  const std::string page = make_html_report(make_report("explained"), make_series());
  for (const char* text :
       {"Dry friction.", "2.96 to 3.08", "leaves a step at every reversal", "13.8", "1.05", "lift it",
        "Stribeck friction", "velocity reversal", "1.2 to 1.38", "run it", "a note", "Something acts."}) {
    EXPECT_THAT(page, HasSubstr(text));
  }
}

TEST(HtmlReport, EscapesNamesFromTheExperiment) {
  const std::string evil = "<script>alert('x')</script>&\"";
  json report = make_report("explained"), series = make_series();
  report["findings"][0]["where"]["joint"] = report["findings"][0]["statement"] = report["findings"][0]["effect"] = evil;
  report["mismatch"][0]["signal"] = report["mismatch"][0]["regime"] = report["verdict"] = evil;
  series["experiment"] = series["robot"] = series["signals"][0]["name"] = series["recordings"][0]["file"] = evil;
  series["recordings"][0]["marks"][0]["where"] = series["recordings"][0]["marks"][0]["kind"] = evil;
  series["clouds"][0]["title"] = series["updated"]["text"] = series["rivals"][0]["why"] = evil;
  const std::string page = make_html_report(report, series);
  EXPECT_THAT(page, Not(HasSubstr("<script")));
  EXPECT_EQ(find_fault(page), "");
}

TEST(HtmlReport, LoadsNothingFromElsewhere) {
  const std::string page = make_html_report(make_report("explained"), make_series());
  for (const char* link : {"http", "src=", "url(", "@import", "<link", "<script"})
    EXPECT_THAT(page, Not(HasSubstr(link)));
}

TEST(HtmlReport, IsTheSameForTheSameInput) {
  EXPECT_EQ(make_html_report(make_report("explained"), make_series()),
            make_html_report(make_report("explained"), make_series()));
}

// Replaces one value at a time, at every depth, by values of the wrong type: a part may be left out, nothing may throw.
void corrupt(const json& whole, const json::json_pointer& at, const std::function<void(const json&)>& check) {
  for (const json& wrong : {json(), json("text"), json(-1), json::array({1, "x"}), json{{"a", 1}}}) {
    json copy = whole;
    copy[at] = wrong;
    check(copy);
  }
  const json& here = whole[at];
  if (!here.is_structured()) return;
  for (const auto& [key, value] : here.items()) {
    (void)value;
    corrupt(whole, here.is_array() ? at / std::stoul(key) : at / key, check);
  }
}

TEST(HtmlReport, LeavesOutPartsOfTheWrongTypeInsteadOfFailing) {
  const json report = make_report("explained"), series = make_series();
  corrupt(report, json::json_pointer(),
          [&](const json& bad) { EXPECT_EQ(find_fault(make_html_report(bad, series)), "") << bad; });
  corrupt(series, json::json_pointer(),
          [&](const json& bad) { EXPECT_EQ(find_fault(make_html_report(report, bad)), "") << bad; });
}

TEST(HtmlReport, NamesTheFileThatCannotBeWritten) {
  try {
    write_html_report(make_report("explained"), json(), "/nonexistent/report.html");
    FAIL() << "should throw";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nonexistent/report.html"));
  }
}

// Weights of findings that fall in steps from all of the mismatch to what is left of it.
TEST(HtmlReport, StepsOfTheMismatchAreDrawnOnlyWhereTheyAddUp) {
  const auto draw = [](double first, double second, double explained) {
    json report = {{"explained", explained}, {"findings", json::array()}};
    for (const double weight : {first, second})
      report["findings"].push_back(
          {{"effect", "coulomb_friction"}, {"where", {{"joint", "elbow"}}}, {"weight", weight}});
    return html::make_waterfall(report);
  };
  EXPECT_THAT(draw(0.4, 0.2, 0.6), HasSubstr("40 %"));
  EXPECT_THAT(draw(0.4, 0.2, 0.6), Not(HasSubstr("twice")));
  EXPECT_THAT(draw(0.4, 0.25, 0.6), HasSubstr("counted twice"));
  EXPECT_EQ(draw(1.0, 1.0, 0.4), "");  // ranks, no shares
}

}  // namespace
}  // namespace hrp::diagnosis
