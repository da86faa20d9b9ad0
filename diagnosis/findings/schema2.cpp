// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/findings/schema2.h"

#include <algorithm>
#include <cmath>

#include "common/effects/effect_info.h"
#include "diagnosis/findings/families.h"

namespace hrp::diagnosis {
namespace {

using Json = nlohmann::ordered_json;

// Share of the squares above the noise that the findings remove: of held-out recordings, or of all if none is held out.
double find_explained(const Json& report) {
  if (report["findings"].empty()) return 0.0;
  const Json& fits = report["fit"];
  const Json fit = fits.value(fits.contains("validate") ? "validate" : "train", Json::object());
  const double before = fit.value("before", 0.0), after = fit.value("after", 0.0);
  const double above = before * before - 1.0;
  return above > 0.0 ? std::clamp(1.0 - std::max(0.0, after * after - 1.0) / above, 0.0, 1.0) : 0.0;
}

// True if the intervals of all components contain the value.
bool all_hold(const Json& intervals, double value) {
  if (!intervals.is_array() || intervals.empty()) return false;
  if (!intervals[0].is_array()) return holds(intervals, value);
  return std::all_of(intervals.begin(), intervals.end(), [&](const Json& interval) { return holds(interval, value); });
}

// True if the interval of a parameter contains its neutral value, at which the effect is absent.
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

// True if the finding's own share was found, and it is none: the held-out recordings are as well explained without it.
bool takes_nothing(const Json& finding) { return finding.contains("share") && finding["share"].get<double>() <= 0.0; }

// Grade of a finding. Nothing is certain without held-out recordings or while something else is missing. If another
// family fits as well, both are ambiguous, and so is what takes nothing away.
const char* find_grade(const Json& finding, bool may_be_certain) {
  const std::string own = find_family_name(finding["effect"].get<std::string>());
  const Json others = finding.value("alternatives", Json::array());
  const bool rivalled = std::any_of(others.begin(), others.end(), [&](const Json& a) { return find_family_name(a["effect"].get<std::string>()) != own; });
  if (rivalled || may_be_absent(finding) || takes_nothing(finding)) return get_grade_name(Grade::kAmbiguous);
  return get_grade_name(may_be_certain ? Grade::kCertain : Grade::kSupported);
}

void upgrade_finding(double share, bool may_be_certain, Json* finding) {
  Json& f = *finding;
  if (!f.contains("grade")) f["grade"] = find_grade(f, may_be_certain);
  if (!f.contains("family")) f["family"] = find_family_name(f["effect"].get<std::string>());
  if (!f.contains("share")) f["share"] = std::round(1000.0 * share) / 1000.0;
  if (!f.contains("alternatives")) f["alternatives"] = Json::array();
  for (Json& a : f["alternatives"]) {
    if (!a.contains("family")) a["family"] = find_family_name(a["effect"].get<std::string>());
  }
}

}  // namespace

bool holds(const Json& interval, double value) {
  return interval.is_array() && interval.size() == 2 && interval[0].is_number() && interval[1].is_number() &&
         interval[0].get<double>() <= value && value <= interval[1].get<double>();
}

void make_ambiguous(Json* finding) {
  (*finding)["grade"] = get_grade_name(Grade::kAmbiguous);
  if (finding->contains("statement")) (*finding)["statement"] = say_ambiguous((*finding)["statement"]);
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
    const auto same = [&](const Json& other) { return other["effect"] == entry["effect"] && other.value("where", Json()) == entry.value("where", Json()); };
    if (std::none_of(list.begin(), list.end(), same)) list.push_back(entry);
  }
  (*report)["not_identifiable"] = list;
}

void upgrade_report(Json* report, bool has_held) {
  Json& r = *report;
  if (r.value("schema", 1) == 2) return;
  r["schema"] = 2;
  const double explained = find_explained(r);
  const double each = explained / std::max<double>(1.0, static_cast<double>(r["findings"].size()));
  const bool may_be_certain = has_held && r["verdict"] == "explained";
  for (Json& f : r["findings"]) upgrade_finding(each, may_be_certain, &f);
  if (!r.contains("remaining")) r["remaining"] = Json::array();
  if (!r.contains("ceiling")) r["ceiling"] = r["verdict"] == "explained" ? 1.0 : explained;
  if (!r.contains("explained")) r["explained"] = explained;
  if (!r.contains("missing")) r["missing"] = Json::array();
}

}  // namespace hrp::diagnosis
