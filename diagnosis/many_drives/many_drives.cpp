// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/many_drives/many_drives.h"

#include <algorithm>

#include "diagnosis/evidence/torque/model.h"
#include "diagnosis/evidence/torque/report.h"
#include "diagnosis/many_drives/joint_torques.h"
#include "diagnosis/standing/search.h"

namespace hrp::diagnosis::standing {
namespace {

// The same problem with the equations without drives only.
StandProblem make_without_drives(StandProblem problem) {
  problem.effort.assign(problem.effort.size(), false);
  problem.command = problem.effort;
  problem.slack.clear(), problem.noise.clear(), problem.law.clear();
  return problem;
}

StandProblems make_without_drives(const StandProblems& p) {
  StandProblems out{make_without_drives(p.all), make_without_drives(p.even), make_without_drives(p.odd),
                    make_without_drives(p.wide_even), make_without_drives(p.wide_odd)};
  fill_noise(&out);
  return out;
}

std::vector<DriveLeft> list_drives_left(const StandProblem& p, const Hypothesis& body) {
  std::vector<DriveLeft> out(p.effort.size());
  const TorqueDesign design = make_torque_design(make_joint_torques(p, body));
  const TorqueFit fit = fit_torque(design, {list_usual_terms(design), {}});
  for (size_t i = 0; i < design.joints.size(); ++i) {
    out[static_cast<size_t>(design.joints[i].joint)] = {fit.cross[i], design.joints[i].effective};
  }
  return out;
}

// Converts effects of drives to the coefficients of effects.h; drops those that standing robots have no row for.
Hypothesis place_drives(const Hypothesis& model) {
  Hypothesis out;
  for (Effect e : model) {
    if (e.place.kind == PlaceKind::kSensor) e.place.reading = Reading::kEffort;
    const StandRow* row = find_row(e);
    if (!row || !row->at_drive || (row->apply && !row->from_table)) continue;
    if (row->from_table) e.p = row->from_table(e.p);
    e.p.resize(row->neutral.size(), 0.0);
    out.push_back(e);
  }
  return out;
}

// Judges the nominal model and the complete model with all equations, for the fit and the curves of the report.
StandOutcome compare(const StandProblems& problems, const Hypothesis& all) {
  const StandProblem& p = problems.all;
  StandOutcome out;
  StandJudge judge(p);
  for (const Hypothesis& h : {Hypothesis{}, all}) {
    judge.update_sigma(evaluate(p, h),
                       {evaluate(problems.even, h), evaluate(problems.odd, h), evaluate(problems.wide_even, h),
                        evaluate(problems.wide_odd, h)},
                       h);
  }
  out.channels = judge.list();
  out.nominal = judge.judge({}, evaluate(p, {})), out.chosen = judge.judge(all, evaluate(p, all));
  out.sigma = judge.sigma(), out.widening = 1.0, out.mismatch = true;
  for (const Effect& e : all) out.chosen.std.push_back(Eigen::VectorXd::Zero(static_cast<long>(e.p.size())));
  return out;
}

bool has_other_family(const Json& finding) {
  return std::any_of(finding["alternatives"].begin(), finding["alternatives"].end(),
                     [&](const Json& a) { return a["family"] != finding["family"]; });
}

// Findings of links, feet and sensors. Their grade is at most `supported`, as for the joints, because the drives are
// not completely known.
Json list_body_findings(const StandProblem& p, const StandOutcome& body) {
  Json report = make_stand_report(p, body);
  for (Json& f : report["findings"]) {
    if (f["grade"] == get_grade_name(Grade::kCertain)) f["grade"] = get_grade_name(Grade::kSupported);
    if (has_other_family(f)) f["grade"] = get_grade_name(Grade::kAmbiguous);
  }
  return report["findings"];
}

Json merge(const StandProblem& p, const StandOutcome& body, const StandOutcome& whole, TorqueVerdict torque) {
  Evidence& evidence = torque.evidence;
  evidence.method =
      "joints: " + evidence.method +
      ", with the IMU's motion of the base and the feet's wrenches; links, feet and sensors: equations in "
      "which no drive has a part; errors are shares of each effort's spread";
  fill_torque_fit(torque.torque, &evidence.fit);
  evidence.verdict = find_verdict(evidence);
  for (const std::string& text : p.experiment->warnings) evidence.warnings.push_back(text);
  Json out = make_report(evidence);
  const Json found = list_body_findings(p, body);
  out["model"] = list_whole_model(*p.experiment, torque.model, out["findings"], found);
  for (size_t i = found.size(); i-- > 0;) out["findings"].insert(out["findings"].begin(), found[i]);
  out["mismatch"] = make_stand_report(p, whole)["mismatch"];
  return out;
}

}  // namespace

bool diagnose_many_drives(const StandProblems& problems, int jobs, const Progress& progress, Reports* out) {
  const TorqueVerdict alone = judge_torque(make_joint_torques(problems.all, {}), jobs);
  if (!has_real_drives(alone) && !may_have_real_drives(alone)) return false;
  progress("torques are missing in most joints: first the equations in which no drive has a part");
  const auto drives = [&](const Hypothesis& h) { return list_drives_left(problems.all, h); };
  const StandOutcome body = search_standing(make_without_drives(problems), jobs, progress, drives);
  progress("missing torque of every joint, with what was found");
  const TorqueVerdict torque = judge_torque(make_joint_torques(problems.all, body.chosen.hypothesis), jobs);
  if (!has_real_drives(torque)) return false;
  Hypothesis all = body.chosen.hypothesis;
  for (const Effect& e : place_drives(torque.model)) all.push_back(e);
  const StandOutcome whole = compare(problems, all);
  out->report = merge(problems.all, body, whole, torque);
  out->series = make_stand_series(problems.all, whole);
  return true;
}

}  // namespace hrp::diagnosis::standing
