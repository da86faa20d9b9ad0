// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/link_evidence.h"

#include <algorithm>
#include <cmath>

#include "common/base/rounding.h"
#include "common/effects/units.h"
#include "diagnosis/data/low_pass.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/evidence/gear_deflection.h"
#include "diagnosis/evidence/links/findings.h"
#include "diagnosis/evidence/torque/findings.h"
#include "diagnosis/findings/families.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/simulation/bodies.h"

namespace hrp::diagnosis {
namespace {

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

// Where the finding does not say: its law's default.
double find_value(const Json& parameters, const EffectParameter& p) {
  const double value = read_value(parameters, p);
  return std::isfinite(value) ? value : p.required ? 0.0 : p.value;
}

void remove_from(Json* list, const Json& finding) {
  Json kept = Json::array();
  for (const Json& other : *list) {
    if (!is_same_effect(other, finding)) kept.push_back(other);
  }
  *list = kept;
}

// What is certain of links and of encoders' zeros.
std::vector<Effect> list_known(const Experiment& e, const Json& findings) {
  std::vector<Effect> known;
  for (const Json& f : findings) {
    const EffectInfo* info = find_effect(f["effect"].get<std::string>());
    if (!info || f.value("grade", "") != "certain") continue;
    Effect effect;
    effect.id = info->id;
    if (f["where"].contains("link"))
      effect.place = at_link(e.robot.tree.find_link(f["where"]["link"]));
    else if (info->felt_elsewhere)
      effect.place = at_joint(e.robot.tree.find_joint(f["where"]["joint"]));
    else
      continue;
    if (effect.place.index < 0 || (effect.place.kind == PlaceKind::kLink && info->place != PlaceKind::kLink)) continue;
    for (const EffectParameter& p : info->parameters) effect.p.push_back(find_value(f["parameters"], p));
    known.push_back(effect);
  }
  return known;
}

// Those of joints with torque sensors.
Evidence pick_drives(const Experiment& e, const LinkSensors& sensors, const TorqueVerdict& drives) {
  Evidence out;
  const auto is_measured = [&](const Where& where) {
    return where.contains("joint") && sensors.has_torque(e.robot.tree.find_joint(where["joint"]));
  };
  for (Finding f : drives.evidence.findings) {
    if (!is_measured(f.where)) continue;
    f.statement += " Measured between the drive and the torque sensor behind its gear.";
    out.findings.push_back(std::move(f));
  }
  for (Remaining r : drives.evidence.remaining) {
    if (!is_measured(r.where)) continue;
    r.statement += " This is between the drive and the torque sensor behind its gear.";
    out.remaining.push_back(std::move(r));
  }
  return out;
}

class Merger {
 public:
  Merger(const Experiment& e, const TorqueData& motion, const LinkSensors& sensors, const LinkVerdict& links,
         const std::vector<GearVerdict>& gears, const Evidence& drives, Reports* reports)
      : e_(e),
        motion_(motion),
        sensors_(sensors),
        links_(links),
        gears_(gears),
        drives_(drives),
        report_(reports->report) {}

  void run() {
    Evidence evidence = links_.evidence;
    add_gears(&evidence);
    evidence.verdict = find_own_verdict(evidence);
    own_ = make_report(evidence);
    for (const char* key : {"mismatch", "remaining", "not_identifiable", "warnings"}) append(key);
    drop_excluded();
    replace_gears();
    replace_drives();
    for (const Json& finding : own_["findings"]) add(finding);
    for (const auto& item : own_["fit"]["per_signal"].items()) report_["fit"]["per_signal"][item.key()] = item.value();
    std::string method = report_["prediction"].value("method", "");
    report_["prediction"]["method"] =
        method + (method.empty() ? "" : "; ") +
        "sensors behind the gears: inverse dynamics of the links beyond them along the recorded motion";
    combine_verdicts();
    if (report_["verdict"] == "unexplained" && !report_["findings"].empty()) report_["verdict"] = "partly_explained";
  }

 private:
  Verdict find_own_verdict(const Evidence& evidence) const {
    bool mismatch = links_.mismatch, to_noise = links_.to_noise;
    for (const GearVerdict& gear : gears_) {
      mismatch = mismatch || gear.mismatch;
      to_noise = to_noise && (!gear.mismatch || gear.to_noise || is_known(gear));
    }
    if (!mismatch) return Verdict::kNoMismatch;
    if (to_noise && (links_.agrees || !evidence.findings.empty())) return Verdict::kExplained;
    return find_verdict(evidence);
  }

  void append(const char* key) {
    if (!report_.contains(key)) report_[key] = Json::array();
    for (const Json& item : own_[key]) report_[key].push_back(item);
  }

  // Positions and efforts have told for certain what the two encoders see.
  bool is_known(const GearVerdict& gear) const {
    return std::any_of(gear.findings.begin(), gear.findings.end(), [&](const Finding& f) {
      return f.share > kNearlyAll &&
             std::any_of(report_["findings"].begin(), report_["findings"].end(), [&](const Json& r) {
               return r["effect"] == f.effect && r["where"] == f.where && r.value("grade", "") == "certain";
             });
    });
  }

  void add_gears(Evidence* evidence) const {
    double explained = links_.mismatch ? evidence->explained : 0.0, n = links_.mismatch ? 1.0 : 0.0;
    for (const GearVerdict& gear : gears_) {
      if (gear.mismatch) {
        explained += 1.0 - gear.remaining.share();
        n += 1.0;
      }
    }
    if (n > 0.0) {
      evidence->explained = explained / n;
      evidence->ceiling = 1.0;
    }
    for (const GearVerdict& gear : gears_) {
      for (const Finding& f : gear.findings) evidence->findings.push_back(f);
      evidence->remaining.push_back(gear.remaining);
      evidence->fit.signals.push_back(gear.fit);
      if (gear.zero_found && !is_explained(gear)) evidence->findings.push_back(make_zero(gear));
    }
    sort_findings(&evidence->findings);
  }

  // An offset of the joint's encoder, or of the second one, that was found otherwise.
  bool is_explained(const GearVerdict& gear) const {
    const std::string joint = e_.robot.tree.joint(gear.joint).name;
    const std::string zero = get_effect(EffectId::kJointOffset).name;
    for (const Json& f : report_["findings"]) {
      if (f["effect"] == zero && f["where"].value("joint", "") == joint) return true;
    }
    for (const Finding& f : links_.evidence.findings) {
      if (f.where.contains("sensor") && f.where["sensor"] == gear.fit.signal) return true;
    }
    return false;
  }

  // Two encoders that differ: which of them is off shows where the joint's own would have moved the efforts.
  Finding make_zero(const GearVerdict& gear) const {
    const std::string joint = e_.robot.tree.joint(gear.joint).name;
    const std::string unit = get_joint_unit(e_.robot.tree.joint(gear.joint), "rad");
    const bool told = report_["verdict"] == "explained" || report_["verdict"] == "no_mismatch";
    Finding f = make_finding(get_effect_of(PlaceKind::kSensor, EffectFamily::kZero), {{"sensor", gear.fit.signal}},
                             {make_one("value", unit, -gear.zero, gear.zero_std)});
    f.grade = told && !gear.one_sided && would_show(gear) ? Grade::kSupported : Grade::kAmbiguous;
    f.probability = kSurest;
    f.share = f.weight =
        std::clamp(gear.zero * gear.zero / std::max(1e-300, gear.fit.before * gear.fit.before), 0.0, 1.0);
    f.statement = gear.fit.signal + ": it stands " + number(-gear.zero, 4) + " " + unit +
                  " off the joint's encoder where no torque is passed on (" + get_grade_name(f.grade) + ").";
    if (f.grade == Grade::kAmbiguous)
      f.alternatives.push_back(make_alternative(
          get_effect(EffectId::kJointOffset), {{"joint", joint}}, {make_one("offset", unit, gear.zero, gear.zero_std)},
          "many postures in which gravity turns this joint, with recorded efforts"));
    if (gear.one_sided)
      f.alternatives.push_back(make_alternative(get_effect(EffectId::kBacklash), {{"joint", joint}},
                                                {make_one("gap", unit, 2.0 * std::abs(gear.zero), 2.0 * gear.zero_std)},
                                                "motions in which the joint's torque changes its sign"));
    return f;
  }

  // An offset of the joint's encoder of that size would change some effort by more than its noise.
  bool would_show(const GearVerdict& gear) const {
    const Plant plant = make_plant(e_, {});
    for (const TorqueRecording& r : motion_.recordings) {
      Eigen::MatrixXd q = r.q;
      q.col(gear.joint).array() -= gear.zero;
      const Eigen::MatrixXd change =
          r.smooth_torque(calc_efforts(add_by_hand(plant, e_.recordings[r.index].spec), q, r.v, r.a)) - r.tau;
      for (long j = 0; j < change.cols(); ++j) {
        if (change.col(j).norm() / std::sqrt(static_cast<double>(change.rows())) >
            kUnlikely * e_.joint_noise[static_cast<size_t>(j)][2].sigma)
          return true;
      }
    }
    return false;
  }

  void drop(const Json& f, const std::string& why) {
    remove_from(&report_["findings"], f);
    report_["not_identifiable"].push_back(
        {{"effect", f["effect"]}, {"where", f["where"]}, {"why", why}, {"motion_that_would_tell", ""}});
    dropped_ = true;
  }

  // Two encoders show give and play themselves.
  void replace_gears() {
    const Json before = report_["findings"];
    for (const Json& f : before) {
      const EffectInfo* info = find_effect(f["effect"].get<std::string>());
      if (!info || !info->flexible || !f["where"].contains("joint")) continue;
      for (const GearVerdict& gear : gears_) {
        if (e_.robot.tree.joint(gear.joint).name != f["where"]["joint"]) continue;
        const bool same = std::any_of(gear.findings.begin(), gear.findings.end(),
                                      [&](const Finding& g) { return g.effect == f["effect"]; });
        if (!same) drop(f, "positions and efforts ask for it, but the joint's two encoders show otherwise");
      }
    }
  }

  // Of joints whose torque is measured behind the gear, what is not certain comes from there.
  void replace_drives() {
    const std::string verdict = report_["verdict"];
    if (verdict == "explained" || verdict == "no_mismatch") return;
    Evidence drives = drives_;
    sort_findings(&drives.findings);
    const Json own = make_report(drives);
    for (const Json& r : own["remaining"]) report_["remaining"].push_back(r);
    const Json before = report_["findings"];
    for (const Json& f : before) {
      if (!f["where"].contains("joint") || f.value("grade", "") == "certain") continue;
      const EffectInfo* info = find_effect(f["effect"].get<std::string>());
      const int joint = e_.robot.tree.find_joint(f["where"]["joint"]);
      if (!sensors_.has_torque(joint) || (info && info->flexible)) continue;
      const auto is_in = [&](const Json& list) {
        return std::any_of(list.begin(), list.end(), [&](const Json& g) { return is_same_effect(f, g); });
      };
      if (is_in(own["findings"]) || is_in(own_["findings"])) continue;
      drop(f, "efforts ask for it, but torque measured behind the gear does not");
    }
    for (const Json& f : own["findings"]) add(f);
  }

  // What the sensors would show and do not is no finding.
  void drop_excluded() {
    if (links_.agrees) return;
    const Json before = report_["findings"];
    for (const Json& f : before) {
      if (!links_.excludes(f["effect"], f["where"], get_first_value(f))) continue;
      if (report_.contains("model")) remove_from(&report_["model"], f);
      drop(f, "positions and efforts ask for it, but sensors behind the gears exclude it");
    }
  }

  void add(const Json& finding) {
    for (Json& f : report_["findings"]) {
      if (!is_same_effect(f, finding)) continue;
      const std::string text = " Sensors behind the gears agree: " + finding["statement"].get<std::string>();
      if (f.value("grade", "") != "certain" && finding["grade"] != "ambiguous")
        f = finding;
      else
        f["statement"] = f["statement"].get<std::string>() + text;
      return;
    }
    report_["findings"].push_back(finding);
    if (report_.contains("model") && !report_["model"].empty()) report_["model"].push_back(make_model_entry(finding));
  }

  void combine_verdicts() {
    static const std::vector<std::string> order{"no_mismatch", "explained", "mostly_explained", "partly_explained",
                                                "unexplained"};
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
    report_["explained"] = own_["explained"];
    report_["ceiling"] = own_["ceiling"];
    for (const Json& u : own_["unexplained"]) report_["unexplained"].push_back(u);
    Json& fit = report_["fit"];
    for (const char* role : {"train", "validate"})
      fit[role] = {{"before", round_to(links_.noise_before, 5)}, {"after", round_to(links_.noise_after, 5)}};
  }

  const Experiment& e_;
  const TorqueData& motion_;
  const LinkSensors& sensors_;
  const LinkVerdict& links_;
  const std::vector<GearVerdict>& gears_;
  const Evidence& drives_;
  Json& report_;
  Json own_;
  bool dropped_ = false;
};

}  // namespace

TorqueVerdict judge_drives(const Experiment& e, const LinkSensors& sensors, const LinkVerdict& links, int jobs) {
  const BodyTorques measured = [&](const TorqueRecording& r, double cutoff) {
    Eigen::MatrixXd tau = calc_efforts(make_plant(e, {}, e.recordings[r.index].spec), r.q, r.v, r.a);
    for (const LinkSensor& s : sensors.sensors) {
      if (s.kind != LinkSensorKind::kTorque) continue;
      const Recording& in = e.recordings[r.index];
      const auto [bias, scale] = links.find_torque_fault(s.joint);
      const Eigen::VectorXd read =
          low_pass(resample(in.time, in.other.at(s.name), r.begin, r.step, r.q.rows()), r.step, cutoff);
      tau.col(s.joint) =
          (read.array() - bias) / scale + e.robot.tree.joint(s.joint).rotor_inertia * r.a.col(s.joint).array();
    }
    return tau;
  };
  return judge_torque(make_torque_data(e, measured), jobs);
}

void add_link_evidence(const Experiment& e, const LinkSensors& sensors, int jobs, const Progress& progress,
                       Reports* reports, std::set<std::string>* compared) {
  if (!sensors.any() && sensors.notes.empty()) return;
  progress("sensors behind the gears, along the recorded motion");
  const TorqueData motion = make_torque_data(e);
  const std::vector<Effect> known = list_known(e, reports->report["findings"]);
  const LinkVerdict links = judge_links(e, motion, sensors, known);
  const std::vector<GearVerdict> gears = judge_gears(e, motion, sensors, known);
  const bool torque = std::any_of(sensors.sensors.begin(), sensors.sensors.end(),
                                  [](const LinkSensor& s) { return s.kind == LinkSensorKind::kTorque; });
  Evidence drives;
  if (torque) drives = pick_drives(e, sensors, judge_drives(e, sensors, links, jobs));
  for (const Finding& f : links.evidence.findings) progress("    " + f.statement);
  for (const GearVerdict& gear : gears) {
    for (const Finding& f : gear.findings) progress("    " + f.statement);
    compared->insert(gear.fit.signal);
  }
  for (const LinkSensor& s : sensors.sensors) compared->insert(s.name);
  Merger(e, motion, sensors, links, gears, drives, reports).run();
}

}  // namespace hrp::diagnosis
