// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/fixed_base.h"

#include <algorithm>
#include <cmath>

#include "common/effects/units.h"
#include "diagnosis/estimate/series.h"
#include "diagnosis/evidence/plain_model.h"
#include "diagnosis/evidence/polish.h"
#include "diagnosis/findings/schema2.h"
#include "diagnosis/findings/suspect_predictions.h"
#include "diagnosis/torque_report.h"
#include "diagnosis/evidence/torque_findings.h"
#include "diagnosis/search/drive_search.h"
#include "diagnosis/search/subtrees.h"
#include "diagnosis/simulation/windows.h"

namespace hrp::diagnosis {
namespace {

// Times the noise that friction and rotors of every joint leave at a real machine: in a clean world little is left of
// one effect once it is modelled.
constexpr double kFar = 5.0;

// The nominal model is exact for some joint: a simulated world, where a law that leaves more than noise is not the law.
// No real robot has such a joint beside others that are wrong.
bool is_exact_world(const TorqueVerdict& torque) { return torque.joints > 1 && torque.exact > 0; }

bool is_effort_driven(const Problem& problem) { return problem.experiment->scenario.drive == "effort"; }

Trial simulate(const Problem& problem, const Hypothesis& hypothesis) {
  Trial trial;
  trial.hypothesis = hypothesis;
  trial.refined = true;
  const std::vector<int>& held = get_judged(problem);
  trial.train = calc_score(problem, hypothesis, problem.train);
  trial.validate = calc_score(problem, hypothesis, held);
  trial.rms = trial.validate.rms(), trial.worst = trial.validate.worst();
  for (const Effect& effect : hypothesis) trial.std.emplace_back(effect.p.size(), 0.0);
  return trial;
}

// The same with one or two joints that are driven by recorded efforts: their drives' effects are there, and much is
// left beside them. Sets of effects are compared by simulation, which from efforts says little.
bool looks_real(const Problem& problem, const TorqueVerdict& torque) {
  if (!is_effort_driven(problem) || !torque.judged) return false;
  const Trial model = simulate(problem, torque.model);
  return torque.any_drives >= kEveryDrive * torque.joints && model.validate.ok && model.rms > kFar;
}

WindowErrors calc_windows(const Problem& problem, const Hypothesis& hypothesis) {
  const Plant plant = make_plant(*problem.experiment, hypothesis);
  return calc_window_errors(plant, *problem.experiment, problem.smooth, get_judged(problem), problem.jobs);
}

// Simulated positions of held-out recordings over their spread, root mean square over joints: what a user looks at.
// From recorded efforts over short windows.
double calc_position_error(const Problem& problem, const Trial& trial) {
  const Experiment& e = *problem.experiment;
  std::vector<double> windows;
  if (is_effort_driven(problem)) windows = calc_windows(problem, trial.hypothesis).rms;
  double sum = 0.0, n = 0.0;
  for (int j = 0; j < e.num_joints(); ++j) {
    const size_t c = static_cast<size_t>(j) * kQuantities;
    const double spread = calc_channel_spread(e, get_judged(problem), c);
    const double error = windows.empty() ? trial.validate.rms(c) / problem.weights[c] : windows[static_cast<size_t>(j)];
    if (spread > 0.0 && std::isfinite(error)) sum += error * error / (spread * spread), n += 1.0;
  }
  return n > 0.0 ? std::sqrt(sum / n) : trial.rms;
}

constexpr double kUnnamed = 0.9;  // of the error of models whose effects the report names

// Faults of logs are told by the servo's own law, whatever else is in a model.
Hypothesis add_logs(Hypothesis model, const Hypothesis& of) {
  for (const Effect& e : of) {
    if (find_place_kind(e.id) == PlaceKind::kSensor && !contains(model, e.id, e.place)) model.push_back(e);
  }
  return model;
}

// From recorded efforts a simulation is drawn to the recording: nothing is judged by it.
std::vector<SuspectJoint> find_suspects(const Problem& problem) {
  return is_effort_driven(problem) ? std::vector<SuspectJoint>{} : find_suspect_joints(problem);
}

// Of several models the one that simulates the held-out recordings best; nothing is fitted to them.
Trial choose_model(const Problem& problem, const Problem& whole, const Hypothesis& model, const Trial* searched,
                   const Progress& progress) {
  Trial best;
  double least = 1e300;
  const auto consider = [&](const char* name, const Trial& other) {
    if (!other.validate.ok) return 1e300;
    const double error = calc_position_error(whole, other);
    progress("    " + std::string(name) + ": held out, positions miss " + number(100.0 * error, 3) + " % of their spread");
    if (error < least) best = other, least = error;
    return error;
  };
  const Hypothesis plain = add_logs(make_plain_model(fit_plain_model(whole)), model),
                   geared = add_logs(make_plain_model(fit_plain_model(whole, true)), model);
  consider("parameters of the missing torque", simulate(whole, model));
  const double without = consider("friction and rotors by least squares", simulate(whole, plain));
  const double with = consider("friction, rotors and gears by least squares", simulate(whole, geared));
  // Recorded efforts are no commands: a simulation from them drifts, and parameters fitted through it mean little.
  if (!is_effort_driven(problem)) {
    consider("fitted through each joint's simulation", simulate(whole, polish_joints(problem, model)));
    consider("least squares, fitted through it", simulate(whole, polish_joints(problem, with < without ? geared : plain)));
  }
  if (!is_effort_driven(problem) && least < 1e300) {
    consider("the best of these with richer laws", simulate(whole, polish_joints(problem, best.hypothesis, true)));
    consider("the best of these, fitted through the whole robot", simulate(whole, polish_whole(whole, best.hypothesis)));
  }
  // Its effects have no names in the report: it has to be clearly better than models of friction, rotors and gears.
  least *= kUnnamed;
  if (searched) consider("the model of the search", simulate(whole, split_asymmetry(searched->hypothesis)));
  return least < 1e300 ? best : simulate(whole, model);
}

void say(const TorqueVerdict& torque, const Progress& progress) {
  for (const std::string& text : torque.evidence.warnings) progress("note: " + text);
  for (const std::string& text : torque.evidence.missing) progress("note: " + text);
  if (!torque.judged) return;
  progress("missing torque along the recorded motion: " + number(100.0 * torque.evidence.explained, 3) +
           " % of it is explained, at most " + number(100.0 * torque.evidence.ceiling, 3) + " % can be");
  for (const Finding& f : torque.evidence.findings) progress("    " + f.statement);
}

// Positions by free simulation of short windows, for recorded efforts.
std::vector<SignalFit> list_windows(const Problem& problem, const Outcome& outcome) {
  std::vector<SignalFit> list;
  const WindowErrors before = calc_windows(problem, {}), after = calc_windows(problem, outcome.chosen.hypothesis);
  for (size_t j = 0; j < before.rms.size(); ++j) {
    const double spread = calc_channel_spread(*problem.experiment, get_judged(problem), j * kQuantities);
    if (!std::isfinite(before.rms[j]) || spread <= 0.0) continue;
    const JointSpec& joint = problem.experiment->robot.tree.joint(static_cast<int>(j));
    list.push_back({signal_name(*problem.experiment, j * kQuantities), get_joint_unit(joint, "rad"), before.rms[j], after.rms[j], spread});
  }
  return list;
}

// Fit of the simulation; for recorded efforts that of the torque: a simulation from them drifts whatever the model.
void fill_fit(const Problem& problem, const Outcome& outcome, const TorqueVerdict& torque, Evidence* evidence) {
  Fit& fit = evidence->fit;
  if (!is_effort_driven(problem)) {
    fit = calc_simulation_fit(problem, outcome.nominal, outcome.chosen);
    evidence->method = "simulation from the recording's commands; findings from the " + evidence->method;
    evidence->horizon = problem.experiment->recordings[0].duration();
    return;
  }
  fill_torque_fit(torque.torque, &fit);
  evidence->method += "; errors are shares of each effort's spread; positions by simulation from the recorded efforts over " +
                      number(kWindow, 2) + " s";
  evidence->horizon = kWindow;
  for (const SignalFit& s : list_windows(problem, outcome)) fit.signals.push_back(s);
}

Reports make_torque_reports(const Problem& problem, const Outcome& outcome, TorqueVerdict torque) {
  Reports reports = make_reports(problem, outcome);
  Evidence& evidence = torque.evidence;
  fill_fit(problem, outcome, torque, &evidence);
  for (const std::string& text : problem.experiment->warnings) evidence.warnings.push_back(text);
  evidence.verdict = find_verdict(evidence);
  const Json mismatch = reports.report["mismatch"];
  reports.report = make_report(evidence);
  reports.report["mismatch"] = mismatch;
  reports.report["model"] = list_torque_model(*problem.experiment, outcome.chosen.hypothesis, reports.report["findings"]);
  reports.series["prediction"] = reports.report["prediction"];
  return reports;
}

std::string list_joints(const Experiment& e, const std::vector<int>& joints) {
  std::string names;
  for (int joint : joints) names += (names.empty() ? "" : ", ") + e.robot.tree.joint(joint).name;
  return names;
}

// Recordings in which a servo hums: no simulation follows them. What is missing at the joints that it does not shake is
// judged along the recorded motion.
Reports judge_beside_hum(const Problem& problem, const Hum& hum) {
  const Experiment& e = *problem.experiment;
  const std::string why = "the recordings contradict themselves at " + list_joints(e, hum.humming) +
                          ": the effort is at its limit for most of the time and the velocity is not the rate of the position, so the "
                          "servo hums faster than the log samples. Not judged, nor called physics: " + list_joints(e, hum.shaken);
  TorqueData data = make_torque_data(e);
  for (TorqueRecording& r : data.recordings) {
    for (int joint : hum.shaken) r.use.col(joint).setConstant(false);
  }
  TorqueVerdict torque = judge_torque(std::move(data), problem.jobs);
  Reports reports = make_empty_reports(problem, why);
  if (!torque.judged) return reports;
  fill_torque_fit(torque.torque, &torque.evidence.fit);
  torque.evidence.warnings.push_back(why);
  torque.evidence.verdict = find_verdict(torque.evidence);
  reports.report = make_report(torque.evidence);
  reports.report["model"] = list_torque_model(e, torque.model, reports.report["findings"]);
  return reports;
}

// Without the recordings whose log freezes, as long as others are left.
std::vector<int> leave_out(const std::vector<int>& recordings, const std::vector<size_t>& frozen) {
  std::vector<int> left;
  for (int r : recordings) {
    if (std::find(frozen.begin(), frozen.end(), static_cast<size_t>(r)) == frozen.end()) left.push_back(r);
  }
  return left.empty() ? recordings : left;
}

}  // namespace

Reports diagnose_fixed_base(const Problem& given, const Progress& progress) {
  const Hum hum = find_hum(*given.experiment);
  if (!hum.humming.empty()) return judge_beside_hum(given, hum);
  progress("inverse dynamics along the recorded motion");
  TorqueVerdict torque = judge_torque(*given.experiment, given.jobs);
  say(torque, progress);
  Problem problem = given;
  problem.train = leave_out(given.train, torque.frozen), problem.validate = leave_out(given.validate, torque.frozen);
  Problem whole = problem;
  split_subtrees(&whole);
  Outcome outcome;
  const bool several = has_real_drives(torque);
  if (several || (!is_exact_world(torque) && looks_real(whole, torque))) {
    progress("friction and rotors in most joints: sets of a few effects are not searched");
    outcome.nominal = outcome.chosen = simulate(whole, {});
    outcome.mismatch = true;
    if (!several) search_drives(problem, progress, &outcome);
  } else {
    outcome = search_subtrees(whole, progress);
    if (!torque.judged || !outcome.mismatch || outcome.explained || torque.evidence.findings.empty() ||
        is_exact_world(torque)) {
      Reports reports = make_reports(whole, outcome);
      doubt_suspects(*problem.experiment, find_suspects(problem), &reports.report);
      upgrade_report(&reports.report, !problem.validate.empty());
      if (problem.validate.empty() && torque.judged) doubt_unconfirmed(torque.evidence.findings, &reports.report);
      return reports;
    }
  }
  progress("simulation with what was found");
  const Trial searched = outcome.chosen;
  outcome.chosen = choose_model(problem, whole, torque.model, outcome.modelled ? &searched : nullptr, progress);
  outcome.modelled = true, outcome.partly = false, outcome.worth.clear(), outcome.doubts.clear(), outcome.twins.clear();
  progress("held out: " + number(outcome.nominal.rms, 4) + " -> " + number(outcome.chosen.rms, 4) + " times the noise");
  Reports reports = make_torque_reports(whole, outcome, std::move(torque));
  warn_of_suspects(*problem.experiment, find_suspects(problem), &reports.report);
  return reports;
}

}  // namespace hrp::diagnosis
