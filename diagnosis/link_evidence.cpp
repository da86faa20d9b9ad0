// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/link_evidence.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/rounding.h"
#include "diagnosis/evidence/link_findings.h"
#include "diagnosis/findings/schema2.h"

namespace hrp::diagnosis {
namespace {

bool is_same(const Json& a, const Json& b) { return a["effect"] == b["effect"] && a["where"] == b["where"]; }

// The first number of the first parameter.
double get_first_value(const Json& finding) {
  for (const auto& item : finding["parameters"].items()) {
    const Json& value = item.value().is_object() ? item.value()["value"] : item.value();
    if (value.is_number()) return value.get<double>();
    if (!value.is_array() || value.empty()) return 0.0;
    double square = 0.0;
    for (const Json& v : value) square += v.get<double>() * v.get<double>();
    return std::sqrt(square);
  }
  return 0.0;
}

// NaN where the finding does not say: its law's default.
double find_value(const Json& parameters, const EffectParameter& p) {
  for (const std::string& name : {p.key(), p.name}) {
    if (!parameters.contains(name)) continue;
    const Json& value = parameters[name].is_object() ? parameters[name]["value"] : parameters[name];
    if (value.is_number()) return value.get<double>();
    if (value.is_array() && p.axis >= 0 && static_cast<size_t>(p.axis) < value.size() && value[static_cast<size_t>(p.axis)].is_number())
      return value[static_cast<size_t>(p.axis)].get<double>();
  }
  return p.required ? 0.0 : p.value;
}

void remove_from(Json* list, const Json& finding) {
  Json kept = Json::array();
  for (const Json& other : *list) {
    if (!is_same(other, finding)) kept.push_back(other);
  }
  *list = kept;
}

// What is certain of links and of encoders' zeros.
std::vector<PlacedEffect> list_known(const Experiment& e, const Json& findings) {
  std::vector<PlacedEffect> known;
  for (const Json& f : findings) {
    const EffectInfo* info = find_effect(f["effect"].get<std::string>());
    if (!info || f.value("grade", "") != "certain") continue;
    PlacedEffect effect{info->id, {}, {}};
    if (f["where"].contains("link")) effect.place = at_link(e.robot.tree.find_link(f["where"]["link"]));
    else if (info->id == EffectId::kJointOffset) effect.place = at_joint(e.robot.tree.find_joint(f["where"]["joint"]));
    else continue;
    if (effect.place.index < 0 || (effect.place.kind == PlaceKind::kLink && info->place != PlaceKind::kLink)) continue;
    for (const EffectParameter& p : info->parameters) effect.p.push_back(find_value(f["parameters"], p));
    known.push_back(effect);
  }
  return known;
}

class Merger {
 public:
  Merger(const LinkVerdict& links, Reports* reports) : links_(links), report_(reports->report) {}

  void run() {
    Evidence evidence = links_.evidence;
    evidence.verdict = find_own_verdict(evidence);
    own_ = make_report(evidence);
    for (const char* key : {"mismatch", "remaining", "not_identifiable", "warnings"}) append(key);
    drop_excluded();
    for (const Json& finding : own_["findings"]) add(finding);
    for (const auto& item : own_["fit"]["per_signal"].items()) report_["fit"]["per_signal"][item.key()] = item.value();
    std::string method = report_["prediction"].value("method", "");
    report_["prediction"]["method"] = method + (method.empty() ? "" : "; ") + "sensors behind the gears: inverse dynamics of the links beyond them along the recorded motion";
    combine_verdicts();
  }

 private:
  Verdict find_own_verdict(const Evidence& evidence) const {
    if (!links_.mismatch) return Verdict::kNoMismatch;
    if (links_.to_noise && (links_.agrees || !evidence.findings.empty())) return Verdict::kExplained;
    return find_verdict(evidence);
  }

  void append(const char* key) {
    if (!report_.contains(key)) report_[key] = Json::array();
    for (const Json& item : own_[key]) report_[key].push_back(item);
  }

  // What the sensors would show and do not is no finding.
  void drop_excluded() {
    if (links_.agrees) return;
    const Json before = report_["findings"];
    for (const Json& f : before) {
      if (!links_.excludes(f["effect"], f["where"], get_first_value(f))) continue;
      remove_from(&report_["findings"], f);
      if (report_.contains("model")) remove_from(&report_["model"], f);
      report_["not_identifiable"].push_back({{"effect", f["effect"]}, {"where", f["where"]},
                                             {"why", "positions and efforts ask for it, but sensors behind the gears exclude it"},
                                             {"motion_that_would_tell", ""}});
      dropped_ = true;
    }
  }

  void add(const Json& finding) {
    for (Json& f : report_["findings"]) {
      if (!is_same(f, finding)) continue;
      const std::string text = " Sensors behind the gears agree: " + finding["statement"].get<std::string>();
      if (f.value("grade", "") != "certain" && finding["grade"] != "ambiguous") f = finding;
      else f["statement"] = f["statement"].get<std::string>() + text;
      return;
    }
    report_["findings"].push_back(finding);
    if (report_.contains("model") && !report_["model"].empty())
      report_["model"].push_back({{"effect", finding["effect"]}, {"where", finding["where"]}, {"parameters", finding["parameters"]}, {"grade", finding["grade"]}});
  }

  void combine_verdicts() {
    static const std::vector<std::string> order{"no_mismatch", "explained", "mostly_explained", "partly_explained", "unexplained"};
    const std::string theirs = report_["verdict"], ours = own_["verdict"];
    if (theirs == "not_judged" || theirs == "no_mismatch") {
      if (ours != "no_mismatch" || theirs == "not_judged") take_ours(ours);
      return;
    }
    if (ours == "no_mismatch") {
      if (dropped_ && report_["findings"].empty()) report_["verdict"] = "unexplained";
      return;
    }
    const bool named = !report_["findings"].empty();
    const auto rank = [](const std::string& v) { return std::find(order.begin(), order.end(), v) - order.begin(); };
    std::string worst = rank(ours) > rank(theirs) ? ours : theirs;
    if (worst == "unexplained" && named) worst = "partly_explained";
    report_["verdict"] = worst;
  }

  void take_ours(const std::string& verdict) {
    report_["verdict"] = verdict;
    report_["explained"] = own_["explained"], report_["ceiling"] = own_["ceiling"];
    for (const Json& u : own_["unexplained"]) report_["unexplained"].push_back(u);
    Json& fit = report_["fit"];
    for (const char* role : {"train", "validate"})
      fit[role] = {{"before", round_to(links_.noise_before, 5)}, {"after", round_to(links_.noise_after, 5)}};
  }

  const LinkVerdict& links_;
  Json& report_;
  Json own_;
  bool dropped_ = false;
};

}  // namespace

void add_link_evidence(const Experiment& e, const LinkSensors& sensors, int jobs, const Progress& progress, Reports* reports,
                       std::set<std::string>* compared) {
  if (!sensors.any() && sensors.notes.empty()) return;
  (void)jobs;
  progress("sensors behind the gears, along the recorded motion");
  const TorqueData motion = make_torque_data(e);
  const LinkVerdict links = judge_links(e, motion, sensors, list_known(e, reports->report["findings"]));
  for (const Finding& f : links.evidence.findings) progress("    " + f.statement);
  for (const LinkSensor& s : sensors.sensors) compared->insert(s.name);
  Merger(links, reports).run();
}

}  // namespace hrp::diagnosis
