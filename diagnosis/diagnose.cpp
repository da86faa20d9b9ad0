// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <set>

#include "common/base/has.h"
#include "common/base/join_words.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/findings/grading.h"
#include "diagnosis/fixed_base.h"
#include "diagnosis/floating/checks/drifting_zeros.h"
#include "diagnosis/floating/diagnose.h"
#include "diagnosis/held_feet/held_feet.h"
#include "diagnosis/link_evidence.h"
#include "diagnosis/many_drives/legged.h"
#include "diagnosis/report/report.h"
#include "diagnosis/toss/search.h"

namespace hrp::diagnosis {
namespace {

// Empty when the joints of a robot on a standing base can be simulated from the recordings, else why not.
std::string find_obstacle(const Experiment& e) {
  if (e.scenario.floating_base) return floating::find_obstacle(e);
  if (e.num_joints() == 0) return "the robot has no joints";
  if (!e.scenario.feet.empty() && e.scenario.ground.present)
    return "a foot of a robot on a rail or stand touches the ground, and contact is not predicted here";
  if (e.scenario.drive == "motion") {
    std::string obstacle = "the joints are taken as recorded and no other signal of a fixed base is predicted";
    for (const std::string& note : find_link_sensors(e).notes) obstacle += "; " + note;
    return obstacle;
  }
  for (const Recording& r : e.recordings) {
    for (size_t j = 0; j < r.joints.size(); ++j) {
      const std::string& name = e.robot.tree.joint(static_cast<int>(j)).name;
      if (!r.joints[j].has(Quantity::kPosition))
        return r.spec.name + " has no column /joint_states/" + name + "/position";
    }
  }
  return "";
}

// The first two parts of a column's name: "/imu/hand" of "/imu/hand/angular_velocity/x".
std::string get_source(const std::string& column) {
  return column.substr(0, column.find('/', column.find('/', 1) + 1));
}

// What nothing was compared with, as it is said; empty where something was. Attitude is an estimate of the IMU's own:
// only what the IMU measures is predicted.
std::string find_left_out(const std::string& column, const std::set<std::string>& compared) {
  std::string source = get_source(column);
  const bool any = compared.count(column) > 0 || compared.count(source) > 0;
  if (!any) return source;
  const std::string attitude = source + "/orientation";
  return column.find("/orientation/") == std::string::npos || compared.count(attitude) > 0 ? "" : attitude;
}

// What the standing robot's engine predicts: one IMU with its attitude, and the feet's force sensors.
std::set<std::string> list_compared_standing(const Experiment& e) {
  const std::string imu = "/imu/" + e.scenario.sensors.imus[0].name;
  std::set<std::string> compared{imu, imu + "/orientation"};
  for (const WrenchSpec& wrench : e.scenario.sensors.wrenches) {
    if (has(e.scenario.feet, wrench.link)) compared.insert("/wrench/" + wrench.name);
  }
  return compared;
}

// Readings that were recorded and that nothing was compared with: said, so that nobody takes them for judged.
void say_what_was_not_compared(const Experiment& e, const std::set<std::string>& kinds, const Progress& progress,
                               Reports* reports, const std::set<std::string>& compared = {}) {
  std::set<std::string> sources;
  for (const Recording& recording : e.recordings) {
    for (const auto& column : recording.other) {
      const std::string source = find_left_out(column.first, compared);
      if (kinds.count(source.substr(0, source.find('/', 1))) > 0) sources.insert(source);
    }
  }
  if (sources.empty()) return;
  const std::string text = "recorded but not compared with any prediction: " + join_words(sources) +
                           "; faults of these sensors are neither found nor excluded";
  progress("note: " + text);
  reports->report["warnings"].push_back(text);
  reports->series["notes"].push_back(text);
}

// A robot on its feet by every equation that its sensors allow. Null where nothing can be compared; `reports` then has
// what was missing.
bool judge_legged(const Problem& problem, const Progress& progress, floating::Robots robots, Reports* reports) {
  const Experiment& e = *problem.experiment;
  if (!e.scenario.floating_base) return false;
  const floating::LeggedReport legged = floating::diagnose_legged(e, progress, robots);
  if (!legged.judged) return false;
  reports->report = make_report(legged.evidence);
  reports->series = legged.series;
  return true;
}

// Nothing is left to ask another engine for.
bool is_settled(const Reports& reports) {
  const std::string verdict = reports.report["verdict"];
  return verdict == "no_mismatch" || verdict == "explained" || verdict == "mostly_explained";
}

// Joints are taken as recorded, without efforts: what sensors behind the gears read is all that can be compared.
bool judge_links_alone(const Problem& problem, const Progress& progress, Reports* reports) {
  const Experiment& e = *problem.experiment;
  if (e.scenario.floating_base || e.scenario.drive != "motion" || !e.scenario.feet.empty() || e.num_joints() == 0)
    return false;
  const LinkSensors behind = find_link_sensors(e);
  if (!behind.any()) return false;
  *reports = make_empty_reports(problem, "only sensors behind the gears are compared");
  reports->report = make_report(Evidence{});
  std::set<std::string> compared;
  add_link_evidence(e, behind, problem.jobs, progress, reports, &compared);
  say_what_was_not_compared(e, {"/imu", "/wrench", "/base", "/joint_states_link"}, progress, reports, compared);
  return true;
}

// Most joints follow their equations down to the noise: a simulated world. No real robot has such joints, and there a
// law that leaves more than noise is not the law.
bool is_exact_elsewhere(const Experiment& e, const Json& report) {
  if (e.scenario.drive == "motion") return false;  // joints are taken as recorded: nothing is known of their equations
  std::set<std::string> missed;
  for (const Json& m : report["mismatch"]) {
    const std::string signal = m["signal"];
    if (signal.rfind("/joint_states/", 0) == 0) missed.insert(get_source(signal));
  }
  return static_cast<double>(missed.size()) < kMuch * e.num_joints();
}

void doubt_findings(Json* report) {
  for (Json& f : (*report)["findings"]) make_ambiguous(&f);
  const std::string verdict = (*report)["verdict"];
  if (verdict == "explained" || verdict == "mostly_explained") (*report)["verdict"] = "partly_explained";
}

// Nothing tells what drives do, and no attitude was recorded: only bodies, soles and sensors can be judged. The
// equations of feet know flat feet that stand and every IMU. The standing robot's engine integrates one gyroscope, and
// what that attitude errs by looked like a late IMU, or like a force.
bool is_of_bodies_alone(const Experiment& e) {
  if (!e.scenario.floating_base || e.scenario.drive != "motion") return false;
  return std::none_of(e.recordings.begin(), e.recordings.end(), [](const Recording& r) {
    const bool effort =
        std::any_of(r.joints.begin(), r.joints.end(), [](const JointColumns& j) { return j.has(Quantity::kEffort); });
    const bool attitude = std::any_of(r.other.begin(), r.other.end(),
                                      [](const auto& c) { return c.first.find("/orientation/") != std::string::npos; });
    return effort || attitude;
  });
}

Reports diagnose_still(const Problem& problem, const Progress& progress) {
  Reports reports;
  const Experiment& e = *problem.experiment;
  // Losses in most joints, as real robots have them.
  const bool real = e.scenario.floating_base && many_drives::diagnose_legged(e, problem.jobs, progress, &reports);
  // The standing robot's engine takes no landing for what it is: it would name something for it.
  if (real || judge_legged(problem, progress, floating::Robots::kWalking, &reports)) {
    say_what_was_not_compared(e, {"/joint_states_link"}, progress, &reports);
    return reports;
  }
  Reports bodies;
  const bool judged = is_of_bodies_alone(e) && judge_legged(problem, progress, floating::Robots::kAll, &bodies);
  if (judged && (is_settled(bodies) || !bodies.report["findings"].empty())) return bodies;
  if (standing::diagnose_standing(problem, progress, &reports)) {
    Reports stood;
    const bool open = !judged && !is_settled(reports) &&
                      judge_legged(problem, progress, floating::Robots::kAll, &stood);  // not twice
    if (open && !stood.report["findings"].empty() && reports.report["findings"].empty()) {
      if (is_exact_elsewhere(e, reports.report)) doubt_findings(&stood.report);
      reports = stood;
      say_what_was_not_compared(e, {"/joint_states_link"}, progress, &reports);
      return reports;
    }
    say_what_was_not_compared(e, {"/joint_states_link", "/imu", "/wrench"}, progress, &reports,
                              list_compared_standing(e));
    return reports;
  }
  std::string obstacle = find_obstacle(e);
  if (!obstacle.empty()) {
    std::string why;
    if (toss::diagnose_toss(e, problem.jobs, progress, &reports.report, &reports.series, &why)) return reports;
    if (e.scenario.floating_base && e.num_joints() == 0) obstacle += "; as a tossed body: " + why;
    if (judge_links_alone(problem, progress, &reports)) return reports;
    if (held_feet::diagnose_held_feet(e, problem.jobs, progress, &reports, &why)) return reports;
    if (judge_legged(problem, progress, floating::Robots::kAll, &reports)) return reports;
    if (!e.scenario.floating_base && e.num_joints() > 0 && !e.scenario.feet.empty())
      obstacle += "; equations along the recorded motion: " + why;
    return make_empty_reports(problem, obstacle);
  }
  const LinkSensors behind = find_link_sensors(e);
  std::set<std::string> compared;
  reports = diagnose_fixed_base(problem, progress);
  add_link_evidence(e, behind, problem.jobs, progress, &reports, &compared);
  say_what_was_not_compared(e, {"/imu", "/wrench", "/base", "/joint_states_link"}, progress, &reports, compared);
  return reports;
}

// Before what was found in recordings that were rid of it.
void add_drift(const floating::ZeroDrift& drift, const Progress& progress, Json* report) {
  Evidence evidence;
  evidence.findings = drift.findings;
  Json own = make_report(evidence)["findings"];
  for (Json& f : own) f["drifts"] = true;
  Json& findings = (*report)["findings"];
  findings.insert(findings.begin(), own.begin(), own.end());
  if ((*report)["verdict"] == "no_mismatch") (*report)["verdict"] = "explained";
  for (const Finding& f : drift.findings) progress("    " + f.statement);
}

}  // namespace

Reports diagnose(const Problem& problem, const Progress& progress) {
  const Experiment& e = *problem.experiment;
  const floating::ZeroDrift drift = e.scenario.floating_base ? floating::find_zero_drift(e) : floating::ZeroDrift{};
  if (!drift.found()) return diagnose_still(problem, progress);
  progress("zeros of force sensors drift: first they are taken out");
  const Experiment still = floating::take_out(drift, e);
  Problem rest = problem;
  rest.experiment = &still;
  Reports reports = diagnose_still(rest, progress);
  add_drift(drift, progress, &reports.report);
  return reports;
}

}  // namespace hrp::diagnosis
