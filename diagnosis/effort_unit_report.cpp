// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/effort_unit_report.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/findings/families.h"
#include "diagnosis/findings/finding.h"
#include "diagnosis/report/json.h"

namespace hrp::diagnosis {
namespace {

constexpr const char* kGain = "torque_constant_error";
constexpr double kNormal = 1.96;
constexpr double kLeast = 0.03;  // of a scale: friction that follows neither speed nor direction

// Standard deviation: the bracket is where the scale can be at all.
double calc_std(const EffortUnit& unit) {
  return std::max(kLeast * unit.scale, 0.5 * std::abs(unit.high - unit.low) / kNormal);
}

// Share of squares that goes away when efforts are taken in that unit, held out where something is.
double calc_share(const TorqueData& data, const EffortUnit& unit) {
  const bool held = std::any_of(data.recordings.begin(), data.recordings.end(), [](const TorqueRecording& r) { return !r.train; });
  double before = 0.0, after = 0.0;
  for (const TorqueRecording& r : data.recordings) {
    if (held && r.train) continue;
    for (long k = 0; k < r.kept(); ++k) {
      const double y = r.effort(r.full_row(k), unit.joint), tau = r.tau(r.full_row(k), unit.joint);
      if (r.use(k, unit.joint)) before += std::pow(y - tau, 2), after += std::pow(unit.scale * y - tau, 2);
    }
  }
  return before > 0.0 ? std::clamp(1.0 - after / before, 0.0, 1.0) : 0.0;
}

Json make_finding(const TorqueData& data, const EffortUnit& unit) {
  const Experiment& e = *data.experiment;
  const std::string joint = e.robot.tree.joint(unit.joint).name, column = e.signal_name(unit.joint, Quantity::kEffort);
  const double std = calc_std(unit), share = round_to(calc_share(data, unit), 3);
  const Json scale = make_value(round_to(unit.scale, 5), round_to(std, 3), "1");
  const Json inverse = make_value(round_to(1.0 / unit.scale, 5), round_to(std / (unit.scale * unit.scale), 3), "1");
  std::string statement = joint + ": the effort is no torque: one logged unit is " + number(unit.scale, 3) + " +- " +
                          number(kNormal * std, 2) + " N m (a motor's current, or a share?).";
  if (unit.by_others) statement += " This joint cannot tell; the value is its neighbours'.";
  return {{"effect", kGain},
          {"family", find_family_name(kGain)},
          {"where", {{"joint", joint}}},
          {"parameters", {{"scale", scale}}},
          {"grade", get_grade_name(unit.by_others ? Grade::kAmbiguous : Grade::kSupported)},
          {"probability", 0.99},
          {"share", share},
          {"weight", share},
          {"unit_of_log", true},
          {"statement", statement},
          {"alternatives", Json::array({{{"effect", "sensor_scale"}, {"family", find_family_name("sensor_scale")},
                                         {"where", {{"sensor", column}}}, {"parameters", {{"scale", inverse}}}}})}};
}

void multiply(double factor, Json* scale) {
  if (scale->is_number()) {
    *scale = scale->get<double>() * factor;
    return;
  }
  for (const char* key : {"value", "std"}) (*scale)[key] = (*scale)[key].get<double>() * factor;
  for (Json& end : (*scale)["ci95"]) end = end.get<double>() * factor;
}

// A gain of this joint that was found in converted efforts becomes one of logged efforts.
bool merge(const Json& finding, Json* list) {
  for (Json& other : *list) {
    if (other["effect"] != kGain || other["where"] != finding["where"]) continue;
    multiply(finding["parameters"]["scale"]["value"].get<double>(), &other["parameters"]["scale"]);
    other["unit_of_log"] = true;
    return true;
  }
  return false;
}

}  // namespace

std::vector<EffortUnit> find_effort_units(const Experiment& e) {
  if (e.scenario.floating_base || e.scenario.drive != "effort" || e.num_joints() == 0) return {};
  return find_effort_units(make_torque_data(e));
}

void add_effort_units(const Experiment& as_logged, const std::vector<EffortUnit>& units, Reports* reports) {
  if (units.empty()) return;
  const TorqueData data = make_torque_data(as_logged);
  Json& report = reports->report;
  Json findings = Json::array();
  for (const EffortUnit& unit : units) {
    const Json finding = make_finding(data, unit);
    if (report.contains("model") && !report["model"].empty() && !merge(finding, &report["model"]))
      report["model"].push_back(make_model_entry(finding));
    if (!merge(finding, &report["findings"])) findings.push_back(finding);
  }
  for (const Json& f : report["findings"]) findings.push_back(f);
  report["findings"] = findings;
  if (report["verdict"] == get_verdict_name(Verdict::kNoMismatch) || report["verdict"] == get_verdict_name(Verdict::kUnexplained))
    report["verdict"] = get_verdict_name(Verdict::kPartlyExplained);
  const std::string text = "efforts are logged in another unit; errors in N m are of efforts times the scale that was found";
  report["warnings"].push_back(text);
  reports->series["notes"].push_back(text);
}

}  // namespace hrp::diagnosis
