// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/grading.h"

#include <algorithm>
#include <cmath>

#include "common/effects/effect_info.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

// True if the intervals of all components contain the value.
bool all_hold(const Json& intervals, double value) {
  if (!intervals.is_array() || intervals.empty()) return false;
  if (!intervals[0].is_array()) return holds(intervals, value);
  return std::all_of(intervals.begin(), intervals.end(), [&](const Json& interval) { return holds(interval, value); });
}

// Nothing is certain without held-out recordings or while something else is missing. If another family fits as well, or
// the same one elsewhere, both are ambiguous, and so is what takes nothing away.
Grade find_grade(const Json& finding, bool may_be_certain) {
  const Json& others = finding["alternatives"];
  const bool rivalled = std::any_of(others.begin(), others.end(), [&](const Json& a) {
    return a["family"] != finding["family"] || a["where"] != finding["where"];
  });
  if (rivalled || may_be_absent(finding) || finding["share"].get<double>() <= 0.0) return Grade::kAmbiguous;
  return may_be_certain ? Grade::kCertain : Grade::kSupported;
}

}  // namespace

double calc_explained(const Fit& fit) {
  const bool held = fit.validate_before > 0.0;
  const double before = held ? fit.validate_before : fit.train_before,
               after = held ? fit.validate_after : fit.train_after;
  const double above = before * before - 1.0;
  return above > 0.0 ? std::clamp(1.0 - std::max(0.0, after * after - 1.0) / above, 0.0, 1.0) : 0.0;
}

Json make_graded_report(bool has_held, Evidence evidence) {
  const bool explained = evidence.verdict == Verdict::kExplained;
  evidence.explained = evidence.findings.empty() ? 0.0 : calc_explained(evidence.fit);
  evidence.ceiling = explained ? 1.0 : evidence.explained;
  Json report = make_report(evidence);
  for (Json& f : report["findings"]) {
    if (!is_ambiguous(f)) f["grade"] = get_grade_name(find_grade(f, has_held && explained));
  }
  return report;
}

bool holds(const Json& interval, double value) {
  return interval.is_array() && interval.size() == 2 && interval[0].is_number() && interval[1].is_number() &&
         interval[0].get<double>() <= value && value <= interval[1].get<double>();
}

bool may_be_absent(const Json& finding) {
  const EffectInfo* effect = find_effect(finding["effect"].get<std::string>());
  if (!effect) return false;
  for (const EffectParameter& p : effect->parameters) {
    if (std::isnan(p.neutral) || !finding["parameters"].contains(p.name)) continue;
    const Json& stated = finding["parameters"][p.name];
    if (stated.is_object() && stated.contains("ci95")) return all_hold(stated["ci95"], p.neutral);
  }
  return false;
}

double read_number(const Json& parameters, const char* name, double missing) {
  if (!parameters.contains(name) || !parameters[name].is_object() || !parameters[name]["value"].is_number())
    return missing;
  return parameters[name]["value"].get<double>();
}

bool is_ambiguous(const Json& finding) { return finding.value("grade", "") == get_grade_name(Grade::kAmbiguous); }

void make_ambiguous(Json* finding) {
  (*finding)["grade"] = get_grade_name(Grade::kAmbiguous);
  if (finding->contains("statement")) (*finding)["statement"] = say_ambiguous((*finding)["statement"]);
}

bool is_same_effect(const Json& a, const Json& b) {
  return a["effect"] == b["effect"] && a.value("where", Json()) == b.value("where", Json());
}

Json state_as_alternative(const Json& finding) {
  return {{"effect", finding["effect"]},
          {"family", finding["family"]},
          {"where", finding["where"]},
          {"parameters", finding["parameters"]}};
}

void doubt_unconfirmed(const std::vector<Finding>& torque, Json* report) {
  for (Json& f : (*report)["findings"]) {
    const auto same = std::find_if(torque.begin(), torque.end(), [&](const Finding& t) {
      return f["effect"] == t.effect && f["where"] == Json(t.where);
    });
    if (same != torque.end() && same->grade != Grade::kAmbiguous) continue;
    make_ambiguous(&f);
    if (same == torque.end()) continue;
    for (const Json& a : make_alternatives(same->alternatives)) f["alternatives"].push_back(a);
  }
}

void lower_grades(Json* report) {
  // The held-out prediction is no better, so the values may belong to another cause.
  const bool useless = report->value("explained", 1.0) <= 0.0;
  for (Json& f : (*report)["findings"]) {
    // determined by its size, whatever is predicted
    const bool unit = f.contains("of_log") && f["where"].contains("sensor");
    if (f.contains("grade") && ((useless && !unit) || may_be_absent(f))) make_ambiguous(&f);
  }
}

void list_once(Json* report) {
  if (!report->contains("not_identifiable")) return;
  Json list = Json::array();
  for (const Json& entry : (*report)["not_identifiable"]) {
    const auto same = [&](const Json& other) { return is_same_effect(other, entry); };
    if (std::none_of(list.begin(), list.end(), same)) list.push_back(entry);
  }
  (*report)["not_identifiable"] = list;
}

}  // namespace hrp::diagnosis
